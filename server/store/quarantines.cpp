// Workers that are granted nothing, in the database.
#include "server/store/index.hpp"

namespace tessera::server {

void Index::put_quarantine(const Quarantine& quarantine) {
  writer_.prepare("INSERT OR REPLACE INTO quarantines VALUES(?1, ?2, ?3, ?4)")
      .run(quarantine.name, quarantine.reason, quarantine.by, quarantine.since);
}

void Index::remove_quarantine(const std::string& name) {
  writer_.prepare("DELETE FROM quarantines WHERE name = ?1").run(name);
}

std::vector<Quarantine> Index::quarantines() const {
  const std::lock_guard lock(reading_);
  std::vector<Quarantine> found;
  Statement rows =
      reader_->prepare("SELECT name, reason, imposed_by, since FROM quarantines ORDER BY name");
  for (bool more = rows.run(); more; more = rows.step())
    found.push_back({rows.text(0), rows.text(1), rows.text(2), rows.integer(3)});
  return found;
}

}  // namespace tessera::server

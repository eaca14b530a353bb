#pragma once
#include <boost/asio/awaitable.hpp>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/coordinator/crew.hpp"
#include "server/store/records.hpp"

/// The quarantines that are in force, and that the store says the same. Used on the I/O thread.
namespace tessera::server {

class QuarantineTable {
 public:
  struct Hooks {
    /// Has the store say this of the name, durably; nothing: it is not quarantined. Throws.
    std::function<boost::asio::awaitable<void>(std::string name, std::optional<Quarantine>)> save;
    /// It is in force from here on.
    std::function<void(const Quarantine&)> imposed;
    std::function<void(const std::string& name)> lifted;
  };
  /// `changed` wakes those that wait here; it is also notified by whoever stops the crew.
  QuarantineTable(Crew& crew, Signal& changed, Hooks hooks);

  [[nodiscard]] std::vector<Quarantine> all() const;  ///< by name
  [[nodiscard]] bool contains(const std::string& name) const { return in_force_.contains(name); }
  /// From the store, at a start.
  void restore(Quarantine kept);

  /// What a person says: durable first, then in force. If it throws, all is as it was, and the
  /// store is made to say so. One name's changes come one after another.
  boost::asio::awaitable<void> impose(Quarantine wanted);
  boost::asio::awaitable<void> lift(std::string name);
  /// What the scheduler finds is in force already: it is written when the disk takes it.
  void found(Quarantine made);

 private:
  boost::asio::awaitable<void> turn(std::string name);
  /// What went wrong.
  boost::asio::awaitable<std::exception_ptr> save(std::string name, std::optional<Quarantine> kept);
  /// Sees to it that the store says of the name what is in force.
  void keep(const std::string& name);
  boost::asio::awaitable<void> keep_at_last(std::string name);

  Crew& crew_;
  Signal& changed_;
  Hooks hooks_;
  std::map<std::string, Quarantine> in_force_;
  std::set<std::string> saving_;   ///< names whose change is on its way to the store
  std::set<std::string> keeping_;  ///< names that keep_at_last sees to
};

}  // namespace tessera::server

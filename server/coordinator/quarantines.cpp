#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/coordinator/impl.hpp"

/// Workers that are kept from work, by name: what a person says and what the scheduler finds is
/// kept alike.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

}  // namespace

QuarantineTable::Hooks CoordinatorImpl::quarantine_hooks() {
  QuarantineTable::Hooks hooks;
  hooks.save = [this](std::string name, std::optional<Quarantine> kept) {
    return save_quarantine(std::move(name), std::move(kept));
  };
  hooks.imposed = [this](const Quarantine& one) {
    perform(scheduler_.quarantine(one.name, one.reason, now()));
  };
  hooks.lifted = [this](const std::string& name) { worker_released(name); };
  return hooks;
}

boost::asio::awaitable<void> CoordinatorImpl::save_quarantine(std::string name,
                                                              std::optional<Quarantine> kept) {
  const std::function<void()> save = [this, name, kept] {
    if (kept) {
      store_->put_quarantine(*kept);
    } else {
      store_->remove_quarantine(name);
    }
  };
  co_await on_writer(save);
}

boost::asio::awaitable<void> CoordinatorImpl::quarantine(std::string name, std::string reason) {
  if (!is_plain_name(name))
    throw Error(ErrorKind::bad_input,
                "expected a worker's name, 1 to 128 bytes without control characters",
                {.key = "name"});
  Quarantine wanted;
  wanted.name = std::move(name);
  wanted.reason = std::move(reason);
  wanted.by = "user";
  wanted.since = unix_millis_now();
  co_await quarantines_.impose(std::move(wanted));
}

boost::asio::awaitable<void> CoordinatorImpl::release(std::string name) {
  return quarantines_.lift(std::move(name));
}

void CoordinatorImpl::worker_released(const std::string& name) {
  perform(scheduler_.release(name, now()));
  log::info("worker {} is released", name);
  for (const auto& [id, worker] : workers_) {
    if (worker.info.name != name) continue;
    worker.link->send(wire::Revoke{{}, "this worker is released: it is granted tasks again"});
    hub_.publish("worker", 0, worker_event(id, name, "idle"));
  }
}

void CoordinatorImpl::perform_one(const WorkerQuarantined& barred) {
  const auto found = workers_.find(barred.worker);
  if (found == workers_.end()) return;
  const std::string name = found->second.info.name;
  log::warn("worker {} ({}) is quarantined: {}", barred.worker, name, excerpt(barred.reason, 400));
  send(barred.worker, wire::Revoke{{}, "this worker is quarantined: " + barred.reason});
  hub_.publish("worker", 0, worker_event(barred.worker, name, "quarantined"));
  Quarantine made;
  made.name = name;
  made.reason = barred.reason;
  made.by = "server";
  made.since = unix_millis_now();
  quarantines_.found(std::move(made));
}

}  // namespace tessera::server

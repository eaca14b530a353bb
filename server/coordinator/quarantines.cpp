#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/coordinator/impl.hpp"

/// Workers that are kept from work, by name: what a person says and what the scheduler finds is
/// kept alike.
namespace tessera::server {

namespace {

constexpr Duration retry_first = std::chrono::milliseconds(100);
constexpr Duration retry_most = std::chrono::seconds(10);

Instant now() { return std::chrono::steady_clock::now(); }

}  // namespace

std::vector<Quarantine> CoordinatorImpl::quarantines() const {
  std::vector<Quarantine> all;
  all.reserve(quarantines_.size());
  for (const auto& [name, one] : quarantines_) all.push_back(one);
  return all;
}

boost::asio::awaitable<void> CoordinatorImpl::save_quarantine(std::string name) {
  const auto found = quarantines_.find(name);
  std::optional<Quarantine> kept;
  if (found != quarantines_.end()) kept = found->second;
  const std::function<char()> save = [this, name, kept] {
    if (kept) {
      store_->put_quarantine(*kept);
    } else {
      store_->remove_quarantine(name);
    }
    return char{};
  };
  co_await on_writer<char>(save);
}

boost::asio::awaitable<void> CoordinatorImpl::keep_quarantine(std::string name) {
  for (Duration wait = retry_first; !crew_.stopping(); wait = std::min(2 * wait, retry_most)) {
    try {
      co_await save_quarantine(name);
      co_return;
    } catch (const std::exception& error) {
      log::error("the quarantine of {} could not be kept: {}", name, error.what());
    }
    co_await crew_.pause(wait);
  }
}

boost::asio::awaitable<void> CoordinatorImpl::quarantine(std::string name, std::string reason) {
  if (!is_plain_name(name))
    throw Error(ErrorKind::bad_input,
                "expected a worker's name, 1 to 128 bytes without control characters",
                {.key = "name"});
  std::optional<Quarantine> before;
  if (const auto found = quarantines_.find(name); found != quarantines_.end())
    before = found->second;
  Quarantine wanted;
  wanted.name = name;
  wanted.reason = reason;
  wanted.by = "user";
  wanted.since = unix_millis_now();
  quarantines_[name] = wanted;
  std::exception_ptr error;
  try {
    co_await save_quarantine(name);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  // Another who changed it meanwhile has the last word.
  const auto found = quarantines_.find(name);
  const bool mine = found != quarantines_.end() && found->second == wanted;
  if (error && mine) {
    quarantines_.erase(found);
    if (before) quarantines_[name] = *before;
  }
  if (error) std::rethrow_exception(error);
  if (mine) perform(scheduler_.quarantine(name, reason, now()));
}

boost::asio::awaitable<void> CoordinatorImpl::release(std::string name) {
  const auto kept = quarantines_.extract(name);
  std::exception_ptr error;
  try {
    if (kept) co_await save_quarantine(name);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  if (error) {
    quarantines_.try_emplace(name, kept.mapped());
    std::rethrow_exception(error);
  }
  if (quarantines_.contains(name)) co_return;  // anew, meanwhile
  perform(scheduler_.release(name, now()));
  if (kept) log::info("worker {} is released", name);
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
  if (quarantines_.contains(name)) return;
  Quarantine made;
  made.name = name;
  made.reason = barred.reason;
  made.by = "server";
  made.since = unix_millis_now();
  quarantines_[name] = std::move(made);
  if (!stopping_) crew_.start("a quarantine", keep_quarantine(name));
}

}  // namespace tessera::server

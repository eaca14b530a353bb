#include "server/coordinator/quarantine_table.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/retry.hpp"

namespace tessera::server {

QuarantineTable::QuarantineTable(Crew& crew, Signal& changed, Hooks hooks)
    : crew_(crew), changed_(changed), hooks_(std::move(hooks)) {}

std::vector<Quarantine> QuarantineTable::all() const {
  std::vector<Quarantine> all;
  all.reserve(in_force_.size());
  for (const auto& [name, one] : in_force_) all.push_back(one);
  return all;
}

void QuarantineTable::restore(Quarantine kept) {
  std::string name = kept.name;
  in_force_.insert_or_assign(std::move(name), std::move(kept));
}

boost::asio::awaitable<void> QuarantineTable::turn(std::string name) {
  while (saving_.contains(name) && !crew_.stopping()) co_await changed_.wait();
  if (crew_.stopping()) throw Error(ErrorKind::unreachable, "the coordinator stops");
}

boost::asio::awaitable<std::exception_ptr> QuarantineTable::save(std::string name,
                                                                 std::optional<Quarantine> kept) {
  saving_.insert(name);
  std::exception_ptr error;
  try {
    co_await hooks_.save(name, std::move(kept));
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  saving_.erase(name);
  changed_.notify();
  co_return error;
}

boost::asio::awaitable<void> QuarantineTable::impose(Quarantine wanted) {
  const std::string name = wanted.name;
  co_await turn(name);
  wanted.durable = true;
  const std::exception_ptr error = co_await save(name, wanted);
  if (error) {
    keep(name);  // a commit that failed may be there all the same
    std::rethrow_exception(error);
  }
  in_force_.insert_or_assign(name, wanted);
  hooks_.imposed(wanted);
}

boost::asio::awaitable<void> QuarantineTable::lift(std::string name) {
  co_await turn(name);
  if (in_force_.contains(name)) {
    const std::exception_ptr error = co_await save(name, std::nullopt);
    if (error) {
      keep(name);
      std::rethrow_exception(error);
    }
    in_force_.erase(name);
  }
  hooks_.lifted(name);
}

void QuarantineTable::found(Quarantine made) {
  const std::string name = made.name;
  made.durable = false;
  if (in_force_.try_emplace(name, std::move(made)).second) keep(name);
}

void QuarantineTable::keep(const std::string& name) {
  if (crew_.stopping() || !keeping_.insert(name).second) return;
  crew_.start("a quarantine", keep_at_last(name));
}

boost::asio::awaitable<void> QuarantineTable::keep_at_last(std::string name) {
  for (Duration wait = retry_first;; wait = longer(wait)) {
    while (saving_.contains(name) && !crew_.stopping()) co_await changed_.wait();
    if (crew_.stopping()) co_return;
    std::optional<Quarantine> now;
    if (const auto found = in_force_.find(name); found != in_force_.end()) now = found->second;
    const std::exception_ptr error = co_await save(name, now);
    const auto found = in_force_.find(name);
    const bool same = now.has_value() == (found != in_force_.end());
    if (!error && same) {
      if (now) found->second.durable = true;
      keeping_.erase(name);
      co_return;
    }
    if (error) log::error("the quarantine of {} could not be kept: {}", name, message_of(error));
    if (error) co_await crew_.pause(wait);
  }
}

}  // namespace tessera::server

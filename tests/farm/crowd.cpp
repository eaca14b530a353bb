#include "tests/farm/crowd.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include "common/net/address.hpp"
#include "common/net/framed_stream.hpp"
#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {

namespace asio = boost::asio;

namespace {
constexpr auto beat = std::chrono::milliseconds(300);
constexpr auto patience = std::chrono::seconds(30);

/// As many open files as the system lets this process have: the soft limit is often 1,024.
void raise_file_limit(std::size_t needed) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  if (limit.rlim_max < needed)
    throw std::runtime_error(fmt::format("{} connections need a hard limit of open files above {}",
                                         needed, limit.rlim_max));
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

struct Crowd::Impl {
  asio::io_context io{1};
  net::Address address;
  std::map<JobId, JobPlan> plans;
  std::vector<bool> assigned;  // on the thread below alone
  std::atomic<std::size_t> welcomed = 0, at_work = 0;
  std::atomic<bool> leaving = false;
  mutable std::mutex mutex;
  std::string troubles;
  std::thread thread;

  Impl(const std::string& server, std::size_t count)
      : address(net::parse_address(server, 0)), assigned(count) {}

  asio::awaitable<void> live(std::size_t number);
  void answer(net::FramedStream& stream, const wire::Message& message, std::size_t number);
  void say_trouble(const std::string& what) {
    const std::lock_guard lock(mutex);
    troubles += what + "\n";
  }
};

asio::awaitable<void> Crowd::Impl::live(std::size_t number) {
  try {
    const net::StreamSettings settings{.queue_bytes = 256 * limits::MiB};  // as a worker's outbox
    net::FramedStream stream =
        co_await net::FramedStream::connect(io.get_executor(), address, patience, settings);
    wire::Hello hello;
    hello.name = fmt::format("crowd-{}", number);
    hello.identity = fmt::format("{:032x}", number + 1);
    hello.threads = 1;
    hello.version = "test";
    stream.send(hello);
    const std::optional<net::Incoming> first = co_await stream.receive(patience);
    if (!first || !std::holds_alternative<wire::Welcome>(first->message)) {
      say_trouble(hello.name + " was not welcomed");
      co_return;
    }
    stream.welcomed();
    ++welcomed;
    while (!leaving) {
      const std::optional<net::Incoming> incoming = co_await stream.receive(beat);
      if (incoming) {
        answer(stream, incoming->message, number);
      } else {
        stream.send(wire::Progress{});
      }
    }
    const wire::Bye bye{"the test is over"};
    stream.send(bye);
    co_await stream.finish(patience);
  } catch (const std::exception& error) {
    if (!leaving) say_trouble(fmt::format("crowd-{}: {}", number, error.what()));
  }
}

void Crowd::Impl::answer(net::FramedStream& stream, const wire::Message& message,
                         std::size_t number) {
  const auto* assign = std::get_if<wire::Assign>(&message);
  if (assign == nullptr) return;
  if (!assigned[number]) ++at_work;
  assigned[number] = true;
  if (assign->spec) {
    plans.try_emplace(assign->job, *assign->spec);
    stream.send(wire::Ready{assign->job});
  }
  const AssignedTask task{*assign, plans.at(assign->job)};
  stream.send(ScriptedWorker::result_of(task),
              std::make_shared<const std::vector<std::byte>>(ScriptedWorker::good_tile(task)));
}

Crowd::Crowd(const std::string& address, std::size_t count)
    : impl_(std::make_unique<Impl>(address, count)) {
  constexpr std::size_t other_files = 64;
  raise_file_limit(count + other_files);
  for (std::size_t number = 0; number < count; ++number)
    asio::co_spawn(impl_->io, impl_->live(number), asio::detached);
  impl_->thread = std::thread([this] { impl_->io.run(); });
}

Crowd::~Crowd() {
  impl_->leaving = true;
  impl_->thread.join();
}

bool Crowd::wait_for_welcomes(std::size_t count, Seconds most) const {
  return becomes_true([&] { return impl_->welcomed >= count; }, most);
}

bool Crowd::wait_for_work(std::size_t count, Seconds most) const {
  return becomes_true([&] { return impl_->at_work >= count; }, most);
}

std::string Crowd::troubles() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->troubles;
}

}  // namespace tessera::farm_test

#include "tests/sim/worker.hpp"

#include "tests/sim/coordinator.hpp"

namespace tessera::sim {

Worker::Worker(World& world, std::string identity, double speed, std::string build)
    : world_(world),
      info_{identity, identity, 1, digest_of(build)},
      speed_(speed),
      overhead_(world.random.between(0.0005, 0.01)),
      prepare_seconds_(world.random.between(0.01, 3)) {}

void Worker::when_awake(std::function<void()> what) {
  if (!alive_) return;
  if (world_.events.now() >= silent_until_) {
    what();
    return;
  }
  world_.events.at(silent_until_, [this, what = std::move(what)] { when_awake(what); });
}

void Worker::connect() {
  if (!alive_ || link_) return;
  if (!world_.coordinator->up()) {
    world_.events.after(world_.random.between(0.1, 1.5),
                        [this] { when_awake([this] { connect(); }); });
    return;
  }
  link_ = std::make_shared<Connection>();
  link_->worker = this;
  link_->partition = &partition_;
  const Link link = link_;
  world_.carry(link, true, [this, link] { world_.coordinator->hello(link, info_); });
  for (const auto& [lease, result] : outbox_) deliver(result);
  heartbeat();
  go_on();
}

void Worker::disconnected(const Link& link) {
  when_awake([this, link] {
    if (link_ != link) return;
    link_.reset();
    queue_.clear();  // what runs is finished and offered later
    world_.events.after(world_.random.between(0.05, 2),
                        [this] { when_awake([this] { connect(); }); });
  });
}

void Worker::heartbeat() {
  const Link link = link_;
  if (!alive_ || !link) return;
  when_awake([this, link] {
    if (link_ != link) return;
    std::vector<std::pair<LeaseId, double>> running;
    if (running_)
      running.emplace_back(running_->grant.lease,
                           seconds(world_.events.now() - running_since_) / running_seconds_);
    const auto preparing = preparing_;
    world_.carry(link, true, [this, link, running, preparing] {
      if (preparing) world_.coordinator->preparing(link, *preparing);
      world_.coordinator->progress(link, running);
    });
    world_.events.after(1, [this, link] {
      if (link_ == link) heartbeat();
    });
  });
}

void Worker::assigned(const Assigned& order) {
  when_awake([this, order, link = link_] {
    if (link_ != link) return;
    queue_.push_back(order);
    go_on();
  });
}

void Worker::revoked(const std::vector<LeaseId>& leases) {
  when_awake([this, leases] {
    for (const LeaseId& lease : leases) {
      std::erase_if(queue_, [&](const Assigned& order) { return order.grant.lease == lease; });
      if (!running_ || running_->grant.lease != lease) continue;
      running_.reset();
      ++start_;
    }
    go_on();
  });
}

void Worker::answered(const LeaseId& lease) {
  when_awake([this, lease] { outbox_.erase(lease); });
}

void Worker::go_on() {
  if (!alive_ || running_ || preparing_ || queue_.empty()) return;
  const Assigned order = queue_.front();
  const server::GrantLease& grant = order.grant;
  if (!prepared_.contains(grant.job)) {
    prepare(grant.job);
    return;
  }
  queue_.pop_front();
  running_ = order;
  running_since_ = world_.events.now();
  // Of a pass, maybe, that the job has no more: its time was up in a later life of the coordinator.
  const JobPlan& plan = *world_.disk.jobs.at(grant.job).asked;
  running_seconds_ =
      overhead_ + static_cast<double>(plan.passes.pass(grant.task.pass).count) / speed_;
  const std::uint64_t start = ++start_;
  world_.events.after(running_seconds_,
                      [this, order, start] { when_awake([=, this] { rendered(order, start); }); });
}

void Worker::prepare(JobId job) {
  preparing_ = job;
  world_.events.after(prepare_seconds_, [this, job] {
    when_awake([this, job] {
      preparing_.reset();
      prepared_.insert(job);
      if (const Link link = link_)
        world_.carry(link, true, [this, link, job] { world_.coordinator->ready(link, job); });
      go_on();
    });
  });
}

void Worker::rendered(const Assigned& order, std::uint64_t start) {
  if (start != start_ || !running_) return;
  const server::GrantLease& grant = order.grant;
  running_.reset();
  if (world_.spoil(world_.weather.error, grant.job, grant.task)) {
    if (const Link link = link_) {
      world_.carry(link, true, [this, link, grant] {
        world_.coordinator->failed(link, grant.job, grant.lease);
      });
    }
    go_on();
    return;
  }
  const bool corrupt = world_.spoil(world_.weather.corrupt, grant.job, grant.task);
  const SentResult result{grant.lease, grant.job, grant.task, order.plan, corrupt};
  outbox_[grant.lease] = result;
  if (!world_.calm() && world_.random.chance(world_.weather.late)) {
    ++world_.faults;
    world_.events.after(world_.random.between(0, 20),
                        [this, result] { when_awake([this, result] { deliver(result); }); });
  } else {
    deliver(result);
  }
  if (!world_.calm() && world_.random.chance(world_.weather.duplicate)) {
    ++world_.faults;
    deliver(result);
  }
  go_on();
}

void Worker::deliver(const SentResult& result) {
  if (const Link link = link_) {
    world_.carry(link, true, [this, link, result] { world_.coordinator->result(link, result); });
  }
}

void Worker::crash() {
  alive_ = false;
  if (const Link link = std::exchange(link_, nullptr))
    world_.cut(link, !world_.random.chance(world_.weather.half_open));
}

void Worker::leave() {
  alive_ = false;
  if (const Link link = std::exchange(link_, nullptr)) {
    world_.carry(link, true, [this, link] {
      world_.coordinator->bye(link);
      link->open = false;
    });
  }
}

void Worker::cut_off(double duration, bool sends, bool receives) {
  const Instant until = world_.events.now() + from_seconds(duration);
  if (sends) partition_.to_server = until;
  if (receives) partition_.to_worker = until;
}

void Worker::fall_silent(double duration) {
  silent_until_ = world_.events.now() + from_seconds(duration);
}

}  // namespace tessera::sim

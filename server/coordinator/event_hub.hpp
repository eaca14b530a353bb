#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/coordinator/coordinator.hpp"

/// Events to whoever listens. Used on the I/O thread alone.
namespace tessera::server {

class EventHub {
 public:
  explicit EventHub(boost::asio::any_io_executor executor);
  ~EventHub();
  EventHub(const EventHub&) = delete;
  EventHub& operator=(const EventHub&) = delete;

  /// Events of one job, or of all (those that belong to no job among them). A subscription may
  /// outlive the hub.
  std::unique_ptr<Subscription> subscribe(std::optional<JobId> job);
  /// Gives the event its number and queues it for all whom it concerns. `data` is a JSON object.
  void publish(std::string type, JobId job, std::string data);
  /// Wakes every listener; when their queues are empty they get nothing more.
  void close();
  [[nodiscard]] bool has_listeners();

 private:
  struct Queue;
  class Listener;

  boost::asio::any_io_executor executor_;
  std::vector<std::weak_ptr<Queue>> queues_;
  std::uint64_t last_number_ = 0;
  bool closed_ = false;
};

}  // namespace tessera::server

#include "server/coordinator/result_pipeline.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>

#include "common/base/error.hpp"

namespace tessera::server {

ResultPipeline::ResultPipeline(boost::asio::any_io_executor io, boost::asio::thread_pool& pool,
                               int lanes, Crew& crew, AppendGroup append, Hooks hooks)
    : io_(std::move(io)),
      pool_(pool),
      lanes_(static_cast<std::size_t>(std::max(1, lanes))),
      crew_(crew),
      hooks_(std::move(hooks)),
      writer_(std::move(append),
              {[this](std::vector<ArrivedResult> group) {
                 auto held = std::make_shared<std::vector<ArrivedResult>>(std::move(group));
                 boost::asio::post(io_, [this, held] { hooks_.durable(std::move(*held)); });
               },
               [this](const std::string& reason) {
                 boost::asio::post(io_, [this, reason] { hooks_.refused(reason); });
               }}) {}

void ResultPipeline::arrived(ArrivedResult result, const image::TileExpectation& expected) {
  gathered_.emplace_back(std::move(result), expected);
  if (gathered_.size() > 1) return;  // a flush is on its way
  crew_.begun();
  boost::asio::post(io_, [this] {
    flush();
    crew_.finished();
  });
}

void ResultPipeline::flush() {
  std::vector<Job> jobs = std::exchange(gathered_, {});
  const std::size_t share = std::max<std::size_t>(4, (jobs.size() + lanes_ - 1) / lanes_);
  for (std::size_t first = 0; first < jobs.size(); first += share) {
    const std::size_t last = std::min(first + share, jobs.size());
    auto piece = std::make_shared<std::vector<Job>>(
        std::make_move_iterator(jobs.begin() + static_cast<std::ptrdiff_t>(first)),
        std::make_move_iterator(jobs.begin() + static_cast<std::ptrdiff_t>(last)));
    crew_.begun();
    boost::asio::post(pool_, [this, piece] { decode(std::move(*piece)); });
  }
}

void ResultPipeline::decode(std::vector<Job> jobs) {
  std::vector<ArrivedResult> good;
  auto bad = std::make_shared<std::vector<std::pair<ArrivedResult, std::string>>>();
  good.reserve(jobs.size());
  for (auto& [result, expected] : jobs) {
    try {
      auto decoded = std::make_shared<DecodedTile>(server::decode(result.exr, expected));
      decoded->budget = result.budget;
      result.decoded = std::move(decoded);
      good.push_back(std::move(result));
    } catch (const std::exception& error) {
      bad->emplace_back(std::move(result), error.what());
    }
  }
  if (!good.empty()) writer_.add(std::move(good));
  boost::asio::post(io_, [this, bad] {
    for (const auto& [result, reason] : *bad) hooks_.invalid(result, reason);
    crew_.finished();
  });
}

}  // namespace tessera::server

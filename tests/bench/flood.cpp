#include "tests/bench/flood.hpp"

#include <algorithm>
#include <random>

namespace tessera::farm_test {

namespace {
ScriptedHello hello(int number) {
  ScriptedHello hello;
  hello.identity.replace(0, 1, std::to_string(number));
  hello.name = "flood-" + std::to_string(number);
  return hello;
}
}  // namespace

Flood::Flood(const std::string& address, int number) : worker_(address, hello(number)) {
  std::mt19937 random(static_cast<unsigned>(number));
  std::uniform_real_distribution<float> uniform(0.5F, 1);
  for (float& value : noise_) value = uniform(random);
}

void Flood::run() {
  while (!stop) {
    const auto task = worker_.next_task(Seconds(3));
    if (!task) return;
    wire::Result result = ScriptedWorker::result_of(*task);
    result.seconds = 1e-5;
    const std::vector<std::byte> exr = tile_for(*task);
    if (!worker_.say(result, exr)) return;
    ++delivered;
    bytes += static_cast<std::int64_t>(exr.size());
  }
}

// Noise, each tile another piece of it: mantissas are random as a renderer's are, so that the
// picture's file is as hard to compress.
std::vector<std::byte> Flood::tile_for(const AssignedTask& task) {
  const Rect window = task.plan.grid.tile(task.assign.task.tile);
  auto& made = made_[{task.assign.task.pass, window.width, window.height}];
  if (made.values.empty()) made = ScriptedWorker::good_image(task);
  made.window = window;
  made.film_width = task.plan.grid.film_width();
  made.film_height = task.plan.grid.film_height();
  constexpr std::size_t step = 4099;
  const std::size_t room = noise_.size() - made.values.size();
  const auto from = static_cast<std::ptrdiff_t>(++tiles_ * step % room);
  std::copy_n(noise_.begin() + from, made.values.size(), made.values.begin());
  return image::encode_tile(made);
}

Floods::Floods(const std::string& address, int count) {
  for (int number = 0; number < count; ++number) {
    floods_.push_back(std::make_unique<Flood>(address, number));
    threads_.emplace_back([flood = floods_.back().get()] { flood->run(); });
  }
}

Floods::~Floods() {
  for (const auto& flood : floods_) flood->stop = true;
  for (std::thread& thread : threads_) thread.join();
}

std::int64_t Floods::delivered() const {
  std::int64_t sum = 0;
  for (const auto& flood : floods_) sum += flood->delivered;
  return sum;
}

std::int64_t Floods::bytes() const {
  std::int64_t sum = 0;
  for (const auto& flood : floods_) sum += flood->bytes;
  return sum;
}

}  // namespace tessera::farm_test

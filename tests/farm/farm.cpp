#include "tests/farm/farm.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {

using nlohmann::json;

Farm::Farm() : server_({"/bin/true"}, folder_ / "none") {
  start_server("127.0.0.1:0", "127.0.0.1:0");
}

void Farm::start_server(const std::string& http, const std::string& listen) {
  const std::string log = "server-" + std::to_string(++starts_);
  server_ = Process({(programs() / "tessera-server").string(), "--data",
                     (folder_ / "data").string(), "--http", http, "--listen", listen},
                    folder_ / log);
  const auto end = std::chrono::steady_clock::now() + Seconds(60);
  while (server_.output().find('\n') == std::string::npos) {
    if (!server_.running() || std::chrono::steady_clock::now() > end)
      throw std::runtime_error("the coordinator did not start: " + server_.errors());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const json ready = json::parse(server_.output());
  http_ = ready.at("http");
  listen_ = ready.at("listen");
}

void Farm::kill_and_restart_server() {
  server_.kill();
  start_server(http_, listen_);
}

Process& Farm::add_worker(int threads, const std::string& server) {
  const std::string name = "worker-" + std::to_string(workers_.size());
  workers_.push_back(Process(
      {(programs() / "tessera-worker").string(), "--server", server.empty() ? listen_ : server,
       "--threads", std::to_string(threads), "--name", name, "--cache", (folder_ / name).string()},
      folder_ / name));
  return workers_.back();
}

Outcome Farm::tessera(std::vector<std::string> arguments, Seconds most) const {
  std::vector<std::string> all{(programs() / "tessera").string(), "--server", "http://" + http_};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return run(std::move(all), most);
}

std::string Farm::submit(const std::string& scene, std::vector<std::string> arguments) {
  std::vector<std::string> all{"submit", scene};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const Outcome outcome = tessera(all);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  std::string id = outcome.output;
  while (!id.empty() && id.back() == '\n') id.pop_back();
  return id;
}

json Farm::job(const std::string& id) const { return get("/v1/jobs/" + id); }

json Farm::get(const std::string& route) const {
  const Line line(http_);
  line.send("GET " + route + " HTTP/1.1\r\nHost: " + http_ + "\r\nConnection: close\r\n\r\n");
  const std::string answer = line.receive_all(Seconds(10));
  const std::size_t body = answer.find("\r\n\r\n");
  if (body == std::string::npos) return nullptr;
  return json::parse(answer.substr(body + 4), nullptr, false);
}

bool Farm::wait_for_progress(const std::string& id, double progress, Seconds most) const {
  const auto end = std::chrono::steady_clock::now() + most;
  while (std::chrono::steady_clock::now() < end) {
    const json now = job(id);
    if (now.is_object() && now.value("progress", 0.0) >= progress) return true;
    if (now.is_object() && now.value("state", "") == "failed") return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

bool Farm::wait_for_workers(std::size_t count, Seconds most) const {
  const auto end = std::chrono::steady_clock::now() + most;
  while (std::chrono::steady_clock::now() < end) {
    const json now = get("/v1/workers");
    if (now.is_object() && now.at("workers").size() == count) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

image::ExrImage Farm::finish(const std::string& id, Seconds most) {
  const Outcome waited = tessera({"wait", id}, most);
  EXPECT_EQ(waited.code, 0) << waited.errors << logs();
  const auto file = folder_ / ("job-" + id + ".exr");
  const Outcome fetched = tessera({"fetch", id, "-o", file.string()});
  EXPECT_EQ(fetched.code, 0) << fetched.errors << logs();
  return fetched.code == 0 ? image::read_exr_file(file) : image::ExrImage{};
}

std::string Farm::logs() const {
  std::string all;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    if (entry.path().extension() == ".err")
      all += "\n---- " + entry.path().filename().string() + "\n" + read_text(entry.path());
  return all;
}

}  // namespace tessera::farm_test

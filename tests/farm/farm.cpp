#include "tests/farm/farm.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {

using nlohmann::json;

Farm::Farm(FarmSettings settings)
    : settings_(std::move(settings)), server_({"/bin/true"}, folder_ / "none") {
  if (settings_.data.empty()) settings_.data = folder_ / "data";
  start_server();
  await_server();
}

void Farm::start_server() {
  std::vector<std::string> command = settings_.run_server;
  for (const std::string& word :
       {(programs() / "tessera-server").string(), std::string("--data"), settings_.data.string(),
        std::string("--http"), http_, std::string("--listen"), listen_})
    command.push_back(word);
  command.insert(command.end(), settings_.flags.begin(), settings_.flags.end());
  server_ = Process(std::move(command), folder_ / ("server-" + std::to_string(++starts_)));
}

void Farm::await_server() {
  const auto speaks = [this] { return server_.output().find('\n') != std::string::npos; };
  becomes_true([&] { return speaks() || !server_.running(); });
  if (!speaks()) throw std::runtime_error("the coordinator did not start: " + server_.errors());
  const json ready = json::parse(server_.output());
  http_ = ready.at("http");
  listen_ = ready.at("listen");
}

void Farm::kill_and_restart_server() {
  server_.kill();
  start_killed_server();
}

void Farm::start_killed_server() {
  start_server();
  await_server();
}

void Farm::kill_server_and_its_successor_after(Seconds wait) {
  server_.kill();
  start_server();
  std::this_thread::sleep_for(wait);
  kill_and_restart_server();
}

Process Farm::start_worker(std::size_t number) const {
  const WorkerFlags& flags = worker_flags_.at(number);
  const std::string name = "worker-" + std::to_string(number);
  std::vector<std::string> command{(programs() / "tessera-worker").string(),
                                   "--server",
                                   flags.server.empty() ? listen_ : flags.server,
                                   "--threads",
                                   std::to_string(flags.threads),
                                   "--name",
                                   name,
                                   "--cache",
                                   (folder_ / name).string()};
  command.insert(command.end(), flags.more.begin(), flags.more.end());
  return Process(std::move(command), folder_ / name);
}

Process& Farm::add_worker(int threads, const std::string& server, std::vector<std::string> flags) {
  worker_flags_.push_back({threads, server, std::move(flags)});
  workers_.push_back(start_worker(workers_.size()));
  return workers_.back();
}

void Farm::kill_and_restart_worker(std::size_t number) {
  workers_.at(number).kill();
  workers_.at(number) = start_worker(number);
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

std::string Farm::ask(const std::string& method, const std::string& route,
                      const std::string& body) const {
  const Line line(http_);
  std::string request =
      method + " " + route + " HTTP/1.1\r\nHost: " + http_ + "\r\nConnection: close\r\n";
  if (!body.empty())
    request +=
        "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  line.send(request + "\r\n" + body);
  const std::string answer = line.receive_all(Seconds(10));
  const std::size_t head = answer.find("\r\n\r\n");
  return head == std::string::npos ? std::string() : answer.substr(head + 4);
}

json Farm::get(const std::string& route) const {
  const std::string body = ask("GET", route, {});
  return body.empty() ? json() : json::parse(body, nullptr, false);
}

json Farm::send(const std::string& method, const std::string& route, const json& body) const {
  const std::string answer = ask(method, route, body.dump());
  return answer.empty() ? json() : json::parse(answer, nullptr, false);
}

double Farm::metric(const std::string& name) const {
  const std::string text = ask("GET", "/metrics", {});
  const std::size_t at = text.find("\n" + name + " ");
  return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
}

bool Farm::wait_for_progress(const std::string& id, double progress, Seconds most) const {
  bool reached = false;
  becomes_true(
      [&] {
        const json now = job(id);
        if (!now.is_object()) return false;
        reached = now.value("progress", 0.0) >= progress;
        return reached || now.value("state", "") == "failed";
      },
      most);
  return reached;
}

bool Farm::wait_for_workers(std::size_t count, Seconds most) const {
  return becomes_true(
      [&] {
        const json now = get("/v1/workers");
        return now.is_object() && now.at("workers").size() == count;
      },
      most);
}

image::ExrImage Farm::finish(const std::string& id, Seconds most) {
  const Outcome waited = tessera({"wait", id}, most);
  EXPECT_EQ(waited.code, 0) << waited.errors << logs();
  const auto file = folder_ / ("job-" + id + ".exr");
  const Outcome fetched = tessera({"fetch", id, "-o", file.string()});
  EXPECT_EQ(fetched.code, 0) << fetched.errors << logs();
  return fetched.code == 0 ? image::read_exr_file(file) : image::ExrImage{};
}

image::ExrImage Farm::fetch_frame(const std::string& id, int frame) const {
  const auto file = folder_ / ("job-" + id + "-frame-" + std::to_string(frame) + ".exr");
  const Outcome outcome =
      tessera({"fetch", id, "--frame", std::to_string(frame), "-o", file.string()});
  EXPECT_EQ(outcome.code, 0) << outcome.errors << logs();
  return outcome.code == 0 ? image::read_exr_file(file) : image::ExrImage{};
}

image::ExrImage Farm::finish_quickly(const std::string& id, Seconds most) const {
  std::string state;
  becomes_true(
      [&] {
        const json now = job(id);
        state = now.is_object() ? now.value("state", "") : "";
        return state == "done" || state == "failed" || state == "cancelled";
      },
      most);
  EXPECT_EQ(state, "done") << "job " << id << logs();
  const auto file = settings_.data / "jobs" / id / "frame-0001.exr";
  return state == "done" ? image::read_exr_file(file) : image::ExrImage{};
}

std::string Farm::logs() const {
  std::string all;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    if (entry.path().extension() == ".err")
      all += "\n---- " + entry.path().filename().string() + "\n" + read_text(entry.path());
  return all;
}

}  // namespace tessera::farm_test

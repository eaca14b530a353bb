#include "client/post.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/commands.hpp"
#include "client/interrupt.hpp"
#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

struct Answer {
  int status = 200;
  std::string body = "{}";
  bool lost = false;       ///< the request is taken, and the connection closed without an answer
  bool interrupt = false;  ///< once the request is there, the process gets SIGINT
};

/// A server on loopback that answers one request after the other as it was told, and then is gone.
class ScriptedServer {
 public:
  explicit ScriptedServer(std::vector<Answer> answers)
      : listening_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (bind(listening_, any, size) != 0 || listen(listening_, 8) != 0 ||
        getsockname(listening_, any, &size) != 0)
      throw Error(ErrorKind::failed, "no port for a test's server");
    url_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this, answers = std::move(answers)] { serve(answers); });
  }
  ~ScriptedServer() { thread_.join(); }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  [[nodiscard]] Settings settings() const { return {.server = url_, .token = {}}; }
  /// The idempotency keys of the requests, once all have been answered.
  std::string keys() {
    requests();
    return keys_;
  }
  /// The first words of the requests' first lines, once all have been answered: "GET /x,POST /y".
  std::string requests() {
    thread_.join();
    thread_ = std::thread([] {});
    return requests_;
  }

 private:
  void serve(const std::vector<Answer>& answers) {
    for (const Answer& answer : answers) {
      pollfd asked{.fd = listening_, .events = POLLIN, .revents = 0};
      if (poll(&asked, 1, 20'000) != 1) break;  // a client that asks no more is seen in requests()
      const int peer = accept(listening_, nullptr, nullptr);
      const std::string request = receive(peer);
      requests_ += (requests_.empty() ? "" : ",") + request.substr(0, request.find(" HTTP/"));
      keys_ += (keys_.empty() ? "" : ",") + key_of(request);
      if (answer.lost) {
        close(peer);
        continue;
      }
      if (answer.interrupt) {
        kill(getpid(), SIGINT);
        // Time for a client that breaks off to do so; one that does not gets its answer.
        pollfd broken{.fd = peer, .events = POLLRDHUP, .revents = 0};
        poll(&broken, 1, 500);
      }
      const std::string text = "HTTP/1.1 " + std::to_string(answer.status) +
                               " Answer\r\nConnection: close\r\nContent-Type: application/json\r\n"
                               "Content-Length: " +
                               std::to_string(answer.body.size()) + "\r\n\r\n" + answer.body;
      (void)send(peer, text.data(), text.size(), MSG_NOSIGNAL);
      close(peer);
    }
    close(listening_);
  }

  /// Headers, and as much of a body as they announce.
  static std::string receive(int peer) {
    std::string out;
    for (char part[4096];;) {
      const std::size_t end = out.find("\r\n\r\n");
      const std::size_t length = out.find("Content-Length: ");
      if (end != std::string::npos) {
        const std::size_t body =
            length < end ? std::stoul(out.substr(length + std::strlen("Content-Length: "))) : 0;
        if (out.size() >= end + 4 + body) return out;
      }
      const ssize_t got = recv(peer, part, sizeof(part), 0);
      if (got <= 0) return out;
      out.append(part, static_cast<std::size_t>(got));
    }
  }

  static std::string key_of(const std::string& request) {
    const std::string field = "Idempotency-Key: ";
    const std::size_t at = request.find(field);
    if (at == std::string::npos) return {};
    return request.substr(at + field.size(), request.find('\r', at) - at - field.size());
  }

  int listening_;
  std::string url_, requests_, keys_;
  std::thread thread_;
};

/// What `action` says in a process of its own, in which signals are caught.
std::string said_by(const std::function<std::string()>& action) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    catch_interrupts();
    const std::string text = action();
    _exit(write(ends[1], text.data(), text.size()) < 0 ? 1 : 0);
  }
  close(ends[1]);
  std::string out;
  char part[256];
  for (ssize_t got = 0; (got = read(ends[0], part, sizeof(part))) > 0;)
    out.append(part, static_cast<std::size_t>(got));
  close(ends[0]);
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
  return out;
}

const std::string job_seven = R"({"id": 7, "state": "queued", "progress": 0})";

TEST(Post, a_signal_does_not_lose_the_id_of_a_job_that_the_server_took) {
  EXPECT_EQ(said_by([] {
              ScriptedServer scripted({{.body = job_seven, .interrupt = true}});
              Server server(scripted.settings());
              const Json job = post_job(server, JobSpec{});
              return job.at("id").dump() + (interrupted() ? " interrupted" : "");
            }),
            "7 interrupted");
}

TEST(Post, a_job_whose_answer_is_lost_is_posted_again_under_the_same_key) {
  ScriptedServer scripted(
      {{.lost = true}, {.lost = true}, {.body = job_seven}, {.body = job_seven}});
  Server server(scripted.settings());
  testing::internal::CaptureStderr();
  EXPECT_EQ(post_job(server, JobSpec{}).at("id"), 7);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("trying again"), std::string::npos);
  post_job(server, JobSpec{});
  const std::string keys = scripted.keys();
  std::vector<std::string> each;
  for (std::size_t at = 0; at <= keys.size();) {
    const std::size_t end = std::min(keys.find(',', at), keys.size());
    each.push_back(keys.substr(at, end - at));
    at = end + 1;
  }
  ASSERT_EQ(each.size(), 4U) << keys;
  EXPECT_GE(each[0].size(), 32U);
  EXPECT_EQ(each[0], each[1]);
  EXPECT_EQ(each[0], each[2]);
  EXPECT_NE(each[0], each[3]) << "another job has another key";
}

TEST(Post, submit_interrupted_takes_its_job_back) {
  const TemporaryFolder folder;
  folder.write("meshes/a.obj", small_mesh);
  JobOptions job;
  job.scene = folder.write("ball.json", small_scene);
  EXPECT_EQ(said_by([&] {
              ScriptedServer scripted({{.body = R"({"missing": []})"},
                                       {.body = job_seven, .interrupt = true},
                                       {.body = job_seven}});
              std::string end = "went on";
              try {
                submit(scripted.settings(), job);
              } catch (const Interrupted&) {
                end = "interrupted";
              }
              return scripted.requests() + " " + end;
            }),
            "POST /v1/blobs/missing,POST /v1/jobs,DELETE /v1/jobs/7 interrupted");
}

TEST(CancelPosted, goes_on_after_a_job_that_has_ended_and_stops_at_a_server_that_is_gone) {
  ScriptedServer scripted({{.status = 409}, {.status = 404}, {.status = 500}, {}, {}});
  Server server(scripted.settings());
  testing::internal::CaptureStderr();
  cancel_posted(server, {1, 2, 3, 4, 5});
  const std::string all = testing::internal::GetCapturedStderr();
  EXPECT_EQ(scripted.requests(),
            "DELETE /v1/jobs/1,DELETE /v1/jobs/2,DELETE /v1/jobs/3,DELETE /v1/jobs/4,"
            "DELETE /v1/jobs/5");
  EXPECT_NE(all.find("cancelled 2 jobs"), std::string::npos) << all;
  EXPECT_NE(all.find("job 3 could not be cancelled"), std::string::npos) << all;
  testing::internal::CaptureStderr();
  cancel_posted(server, {6, 7});
  const std::string gone = testing::internal::GetCapturedStderr();
  EXPECT_NE(gone.find("job 6 could not"), std::string::npos) << gone;
  EXPECT_EQ(gone.find("job 7"), std::string::npos) << gone;
}

}  // namespace
}  // namespace tessera::client

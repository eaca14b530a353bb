// The port over true sockets: what a peer may do to it, and what it says then.
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <thread>

#include "api_fixture.hpp"
#include "server/http/listener.hpp"

namespace tessera::server {
namespace {

using boost::asio::ip::tcp;
using testing::HasSubstr;
using testing::StartsWith;
using namespace std::chrono_literals;

/// A peer that sends what it likes and reads when it likes.
class Peer {
 public:
  explicit Peer(std::uint16_t port, int receive_buffer = 0) {
    socket_.open(tcp::v4());
    if (receive_buffer > 0)
      socket_.set_option(boost::asio::socket_base::receive_buffer_size(receive_buffer));
    socket_.connect({boost::asio::ip::address_v4::loopback(), port});
  }
  void send(std::string_view text) { boost::asio::write(socket_, boost::asio::buffer(text)); }
  /// False if the server had ended the connection before all was sent.
  bool try_send(std::string_view text) {
    boost::system::error_code error;
    boost::asio::write(socket_, boost::asio::buffer(text), error);
    return !error;
  }
  void get(const std::string& path, std::uint16_t port, const std::string& more = {}) {
    send("GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" + more +
         "\r\n");
  }
  /// All that comes until the server ends the connection.
  std::string read_to_end() {
    std::string out;
    boost::system::error_code error;
    boost::asio::read(socket_, boost::asio::dynamic_buffer(out), error);
    return out;
  }
  /// Reads until `mark` has come.
  std::string read_until(std::string_view mark) {
    std::string out;
    while (out.find(mark) == std::string::npos) {
      char c = 0;
      boost::system::error_code error;
      if (socket_.read_some(boost::asio::buffer(&c, 1), error) == 0) break;
      out += c;
    }
    return out;
  }
  std::string read(std::size_t size) {
    std::string out(size, '\0');
    boost::asio::read(socket_, boost::asio::buffer(out));
    return out;
  }

 private:
  boost::asio::io_context context_;
  tcp::socket socket_{context_};
};

/// The listener on a thread of its own, with short patience.
class ConnectionTest : public ApiTest {
 protected:
  void start(std::size_t connections_max = 64) {
    HttpSettings settings;
    settings.port = 0;
    settings.connections_max = connections_max;
    settings.idle_time = 400ms;
    settings.write_time = 300ms;
    listener = HttpListener::open(context.get_executor(), api, files, settings);
    port = listener->port();
    thread = std::thread([this] { context.run(); });
  }
  void stop() {
    if (!listener) return;
    boost::asio::co_spawn(context, listener->stop(), boost::asio::use_future).get();
    thread.join();  // nothing is left to run once the listener has stopped
    listener.reset();
  }
  ~ConnectionTest() override {
    stop();
    files.join();
  }

  std::unique_ptr<HttpListener> listener;
  std::uint16_t port = 0;
  std::thread thread;
};

TEST_F(ConnectionTest, OneConnectionServesManyRequestsInOrder) {
  start();
  Peer peer(port);
  peer.get("/healthz", port);
  EXPECT_THAT(peer.read_until("}\n"), StartsWith("HTTP/1.1 200 OK\r\n"));
  peer.get("/nowhere", port);
  peer.get("/readyz", port,
           "Connection: close\r\n");  // sent before the answer to the first is read
  const std::string both = peer.read_to_end();
  EXPECT_THAT(both, StartsWith("HTTP/1.1 404 Not Found\r\n"));
  EXPECT_THAT(both, HasSubstr("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(both, HasSubstr("Connection: close\r\n"));
}

TEST_F(ConnectionTest, HeadSendsTheLengthAndNoBody) {
  start();
  Peer peer(port);
  peer.send("HEAD /healthz HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
            "\r\nConnection: close\r\n\r\n");
  const std::string answer = peer.read_to_end();
  EXPECT_THAT(answer, HasSubstr("Content-Length: "));
  EXPECT_TRUE(answer.ends_with("\r\n\r\n"));
}

TEST_F(ConnectionTest, GarbageGets400AndTheEnd) {
  start();
  for (const std::string& garbage :
       {std::string("TSRA\x01\x00\x02 this is no HTTP\r\n\r\n", 27), std::string(4000, '\xff'),
        std::string("GET / HTTP/1.1\r\nbroken\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n")}) {
    Peer peer(port);
    peer.try_send(garbage);
    EXPECT_THAT(peer.read_to_end(), StartsWith("HTTP/1.1 400 Bad Request\r\n"))
        << garbage.substr(0, 20);
  }
}

TEST_F(ConnectionTest, AHeaderWithoutEndGets431) {
  start();
  Peer peer(port);
  peer.try_send("GET / HTTP/1.1\r\nX: " + std::string(40'000, 'a'));
  EXPECT_THAT(peer.read_to_end(), StartsWith("HTTP/1.1 431 "));
}

TEST_F(ConnectionTest, TwoLengthsAreNotBelieved) {
  start();
  Peer peer(port);
  peer.try_send("POST /v1/jobs HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
                "\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /healthz "
                "HTTP/1.1\r\n\r\n");
  const std::string answer = peer.read_to_end();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 400 "));
  EXPECT_EQ(answer.find("\nHTTP/1.1 "), std::string::npos) << "the hidden request was answered";
}

TEST_F(ConnectionTest, AnUnknownTransferCodingIsRefused) {
  start();
  Peer peer(port);
  peer.try_send("POST /v1/jobs HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
                "\r\nTransfer-Encoding: identity\r\n\r\n{}");
  EXPECT_THAT(peer.read_to_end(), StartsWith("HTTP/1.1 400 "));
}

TEST_F(ConnectionTest, HalfARequestIsCutOff) {
  start();
  Peer peer(port);
  peer.send("GET / HTTP/1.1\r\nHost: loc");
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(peer.read_to_end(), "");
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
}

TEST_F(ConnectionTest, HalfABodyIsCutOffAndWhatCameIsKept) {
  start();
  const std::string path = "/v1/blobs/" + std::string(64, 'a');
  Peer peer(port);
  peer.send("PUT " + path + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
            "\r\nContent-Length: 1000\r\n\r\nabc");
  EXPECT_EQ(peer.read_to_end(), "");
  Peer other(port);
  other.send("HEAD " + path + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
             "\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(other.read_to_end(), HasSubstr("Upload-Offset: 3\r\n"));
}

TEST_F(ConnectionTest, AClientThatDoesNotReadIsCutOffAndOthersAreServed) {
  coordinator.add(1);
  coordinator.picture_bytes = 64 << 20;
  start();
  Peer slow(port, 4096);
  slow.get("/v1/jobs/1/frames/1/image.exr", port);
  Peer other(port);
  other.get("/healthz", port);
  EXPECT_THAT(other.read_until("}\n"), StartsWith("HTTP/1.1 200 OK\r\n"));
  const auto end = std::chrono::steady_clock::now() + 10s;
  const auto open = [&] {
    Peer asking(port);
    asking.get("/metrics", port, "Connection: close\r\n");
    const std::string text = asking.read_to_end();
    const std::string name = "\ntessera_http_connections ";
    return std::stoi(text.substr(text.find(name) + name.size()));
  };
  while (open() > 1 && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(50ms);
  EXPECT_EQ(open(), 1) << "the slow one, the silent one, or both are still there";
  EXPECT_LT(slow.read_to_end().size(), std::size_t{64} << 20);
}

TEST_F(ConnectionTest, ALargePictureArrivesWhole) {
  coordinator.add(1);
  coordinator.picture_bytes = 20 << 20;
  start();
  Peer peer(port);
  peer.get("/v1/jobs/1/frames/1/image.exr", port, "Connection: close\r\n");
  const std::string answer = peer.read_to_end();
  EXPECT_EQ(answer.size() - answer.find("\r\n\r\n") - 4, std::size_t{20} << 20);
}

TEST_F(ConnectionTest, ABlobGoesThroughWholeUpAndDown) {
  start();
  std::string content(3 << 20, '\0');
  for (std::size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>(i * i >> 7);
  const std::string path = "/v1/blobs/" + digest_of(content).hex();
  const std::string host = "Host: localhost:" + std::to_string(port) + "\r\n";
  Peer peer(port);
  peer.send("PUT " + path + " HTTP/1.1\r\n" + host + "Expect: 100-continue\r\nContent-Length: " +
            std::to_string(content.size()) + "\r\n\r\n");
  EXPECT_EQ(peer.read_until("\r\n\r\n"), "HTTP/1.1 100 Continue\r\n\r\n");
  peer.send(content);
  EXPECT_THAT(peer.read_until("}\n"), StartsWith("HTTP/1.1 201 Created\r\n"));
  peer.get(path, port);
  peer.read_until("\r\n\r\n");
  EXPECT_EQ(peer.read(content.size()), content);
}

TEST_F(ConnectionTest, ABodyInChunksIsTaken) {
  start();
  const std::string path = "/v1/blobs/" + digest_of(std::string_view("hello")).hex();
  Peer peer(port);
  peer.send("PUT " + path + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
            "\r\nTransfer-Encoding: chunked\r\nConnection: "
            "close\r\n\r\n2\r\nhe\r\n3\r\nllo\r\n0\r\n\r\n");
  EXPECT_THAT(peer.read_to_end(), StartsWith("HTTP/1.1 201 Created\r\n"));
}

TEST_F(ConnectionTest, ARefusalIsReadAlthoughTheBodyWasNot) {
  start();
  Peer peer(port);
  peer.send("POST /v1/jobs HTTP/1.1\r\nHost: evil.example\r\nContent-Length: 5000000\r\n\r\n");
  peer.try_send(std::string(5'000'000, 'x'));
  const std::string answer = peer.read_to_end();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 421 Misdirected Request\r\n"));
  EXPECT_THAT(answer, HasSubstr("Connection: close\r\n"));
}

TEST_F(ConnectionTest, EventsComeAsTheyHappenAndCommentsKeepTheStreamAlive) {
  coordinator.events.push_back(FakeCoordinator::event(5, "job", 1, R"({"id":1})"));
  ApiSettings settings = loopback();
  settings.keep_alive = 50ms;
  Api lively(coordinator, blobs, files, settings);
  HttpSettings http;
  http.port = 0;
  http.idle_time = 100ms;
  listener = HttpListener::open(context.get_executor(), lively, files, http);
  port = listener->port();
  thread = std::thread([this] { context.run(); });
  Peer peer(port);
  peer.get("/v1/events", port);
  const std::string head = peer.read_until("\r\n\r\n");
  EXPECT_THAT(head, HasSubstr("Content-Type: text/event-stream\r\n"));
  EXPECT_EQ(head.find("Content-Length"), std::string::npos);
  EXPECT_THAT(peer.read_until("\"id\":1}\n\n"), HasSubstr("id: 5\nevent: job\n"));
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(peer.read_until("\n\n"), ": keep-alive\n\n") << "beyond the idle time";
  stop();
  EXPECT_EQ(peer.read_to_end(), "") << "stopping ends the stream";
}

TEST_F(ConnectionTest, MoreConnectionsThanAllowedAreTold503) {
  start(2);
  Peer first(port);
  Peer second(port);
  first.get("/healthz", port);
  second.get("/healthz", port);
  first.read_until("}\n");
  second.read_until("}\n");
  Peer third(port);
  EXPECT_THAT(third.read_to_end(), StartsWith("HTTP/1.1 503 "));
}

TEST_F(ConnectionTest, StoppingEndsWhatIsUnderWay) {
  coordinator.add(1);
  coordinator.picture_bytes = 64 << 20;
  start();
  Peer slow(port, 4096);
  slow.get("/v1/jobs/1/frames/1/image.exr", port);
  slow.read(100);
  Peer idle(port);
  const auto before = std::chrono::steady_clock::now();
  stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 250ms) << "it waited for a time-out";
}

TEST_F(ConnectionTest, APortInUseIsSaidByItsNumber) {
  start();
  HttpSettings settings;
  settings.port = port;
  try {
    HttpListener::open(context.get_executor(), api, files, settings);
    FAIL() << "two listen on one port";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::failed);
    EXPECT_THAT(error.what(), HasSubstr("127.0.0.1:" + std::to_string(port)));
  }
}

}  // namespace
}  // namespace tessera::server

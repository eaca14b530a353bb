#include "client/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <string_view>
#include <thread>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {

constexpr std::chrono::milliseconds look{20};

/// What a new process is given, made before the fork: behind it nothing may allocate.
struct Start {
  std::string program;
  std::vector<std::string> arguments, environment;
  std::vector<char*> argument_pointers, environment_pointers;
  int log = -1;
  int output = -1;
  pid_t parent = 0;
};

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (std::string& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

[[noreturn]] void become(const Start& start) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != start.parent) _exit(127);  // the parent died before the kernel was asked to tell
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_DFL);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, 0);
  dup2(start.output, 1);
  dup2(start.log, 2);
  execve(start.program.c_str(), start.argument_pointers.data(), start.environment_pointers.data());
  constexpr std::string_view failed = "cannot be executed\n";
  [[maybe_unused]] const ssize_t written = write(2, failed.data(), failed.size());
  _exit(127);
}

[[noreturn]] void fail(const std::string& name, const char* what) {
  throw Error(ErrorKind::failed,
              fmt::format("{} cannot be started: {}: {}", name, what, std::strerror(errno)));
}

}  // namespace

Child::Child(std::string name, const std::filesystem::path& program,
             std::vector<std::string> arguments, std::filesystem::path log)
    : name_(std::move(name)), log_(std::move(log)) {
  Start start;
  start.program = program.string();
  start.arguments = std::move(arguments);
  start.arguments.insert(start.arguments.begin(), start.program);
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (!std::string_view(*variable).starts_with("TESSERA_"))
      start.environment.emplace_back(*variable);
  start.argument_pointers = pointers(start.arguments);
  start.environment_pointers = pointers(start.environment);
  start.parent = getpid();
  start.log = open(log_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (start.log < 0) fail(name_, "its log");
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) {
    close(start.log);
    fail(name_, "a pipe");
  }
  start.output = ends[1];
  pid_ = fork();
  if (pid_ == 0) become(start);
  close(start.log);
  close(start.output);
  output_ = ends[0];
  if (pid_ < 0) {
    close(output_);
    fail(name_, "fork");
  }
  running_ = true;
}

Child::~Child() {
  end_within(Duration::zero());
  close(output_);
}

bool Child::running() {
  if (running_ && waitpid(pid_, &status_, WNOHANG) == pid_) running_ = false;
  return running_;
}

std::string Child::epitaph() const {
  std::string out = WIFSIGNALED(status_)
                        ? fmt::format("{} was killed by signal {} ({})", name_, WTERMSIG(status_),
                                      strsignal(WTERMSIG(status_)))
                        : fmt::format("{} ended with code {}", name_, WEXITSTATUS(status_));
  std::ifstream log(log_);
  std::vector<std::string> lines;
  for (std::string line; std::getline(log, line);) {
    lines.push_back(line.substr(0, 500));
    if (lines.size() > 8) lines.erase(lines.begin());
  }
  for (const std::string& line : lines) out += "\n  " + line;
  return out;
}

std::optional<std::string> Child::first_line(Duration time) {
  const auto end = std::chrono::steady_clock::now() + time;
  std::string line;
  while (std::chrono::steady_clock::now() < end && line.size() < 65536) {
    throw_if_interrupted();
    pollfd waiting{output_, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(look.count())) <= 0) continue;
    char byte = 0;
    const ssize_t got = read(output_, &byte, 1);
    if (got == 0) return std::nullopt;
    if (got < 0) continue;
    if (byte == '\n') return line;
    line += byte;
  }
  return std::nullopt;
}

void Child::ask_to_end() {
  if (running()) kill(pid_, SIGTERM);
}

void Child::end_within(Duration time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (running() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(look);
  if (!running_) return;
  kill(-pid_, SIGKILL);
  kill(pid_, SIGKILL);  // its group may not stand yet
  while (waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
  }
  running_ = false;
}

}  // namespace tessera::client

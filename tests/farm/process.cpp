#include "tests/farm/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace tessera::farm_test {

namespace fs = std::filesystem;

namespace {
int open_log(const fs::path& file) {
  return ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
}
int code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }
}  // namespace

Process::Process(std::vector<std::string> arguments, const fs::path& log) : log_(log) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const int out = open_log(log.string() + ".out");
  const int err = open_log(log.string() + ".err");
  const int in = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (out < 0 || err < 0 || in < 0) throw std::runtime_error("no log files");
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ == 0) {
    dup2(in, 0);
    dup2(out, 1);
    dup2(err, 2);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  close(in);
  close(out);
  close(err);
}

Process::~Process() { kill(); }

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), code_(other.code_), log_(std::move(other.log_)) {}

Process& Process::operator=(Process&& other) noexcept {
  if (this != &other) {
    kill();
    pid_ = std::exchange(other.pid_, -1);
    code_ = other.code_;
    log_ = std::move(other.log_);
  }
  return *this;
}

void Process::signal(int number) const {
  if (pid_ > 0 && !code_) ::kill(pid_, number);
}

std::optional<int> Process::wait(Seconds most) {
  becomes_true([this] { return !running(); }, most, std::chrono::milliseconds(5));
  return code_;
}

void Process::kill() {
  if (pid_ <= 0 || code_) return;
  ::kill(pid_, SIGKILL);
  int status = 0;
  waitpid(pid_, &status, 0);
  code_ = code_of(status);
}

double Process::peak_memory() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}
void Process::forget_peak_memory() const {
  std::ofstream("/proc/" + std::to_string(pid_) + "/clear_refs") << 5;  // proc(5): resets VmHWM
}

bool Process::running() {
  int status = 0;
  if (!code_ && pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) code_ = code_of(status);
  return pid_ > 0 && !code_;
}

std::string Process::output() const { return read_text(log_.string() + ".out"); }
std::string Process::errors() const { return read_text(log_.string() + ".err"); }

Outcome run(std::vector<std::string> arguments, Seconds most) {
  const TemporaryFolder folder;
  Process process(std::move(arguments), folder / "log");
  if (!process.wait(most)) process.kill();
  return {*process.wait(Seconds(0)), process.output(), process.errors()};
}

bool becomes_true(const std::function<bool()>& holds, Seconds most,
                  std::chrono::milliseconds pause) {
  const auto end = std::chrono::steady_clock::now() + most;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(pause);
  }
  return true;
}

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

namespace {
fs::path from_environment(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr) throw std::runtime_error(std::string(name) + " is not set");
  return value;
}
}  // namespace

fs::path programs() { return from_environment("TESSERA_BIN_DIR"); }
fs::path sources() { return from_environment("TESSERA_SOURCE_DIR"); }

}  // namespace tessera::farm_test

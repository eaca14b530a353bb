#include "common/assets/pin_board.hpp"

#include <fcntl.h>

#include <sstream>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "common/base/random.hpp"

namespace tessera::assets {

namespace fs = std::filesystem;

PinBoard::PinBoard(fs::path folder)
    : folder_(std::move(folder)), own_path_(folder_ / "pins" / random_hex(8)) {}

PinBoard::~PinBoard() {
  std::error_code ignored;
  if (own_file_.is_open()) fs::remove(own_path_, ignored);
}

PinBoard::Held PinBoard::hold() {
  std::unique_lock<std::mutex> threads(mutex_);
  File processes(folder_ / "pins.lock", O_RDWR | O_CREAT);
  processes.lock();
  return {*this, std::move(threads), std::move(processes)};
}

std::uint64_t PinBoard::pin(std::vector<Digest> digests) {
  const Held held = hold();
  const std::uint64_t number = ++last_;
  pins_.emplace(number, std::move(digests));
  try {
    publish();
  } catch (...) {
    pins_.erase(number);  // whoever asked does not know its number
    throw;
  }
  return number;
}

void PinBoard::unpin(std::uint64_t number) noexcept {
  try {
    const Held held = hold();
    pins_.erase(number);
    publish();
  } catch (const std::exception&
               error) {  // the blobs stay pinned until this process ends, and no harm is done
    log::warn("cannot take back a pin on cached files: {}", error.what());
  }
}

void PinBoard::publish() {
  if (!own_file_.is_open()) {
    own_file_ = File(own_path_, O_RDWR | O_CREAT | O_EXCL);
    own_file_.lock();
  }
  std::string text;
  for (const Digest& digest : own()) text += digest.hex() + '\n';
  own_file_.truncate(0);
  own_file_.write_at(std::as_bytes(std::span(text)), 0);
}

std::set<Digest> PinBoard::own() const {
  std::set<Digest> digests;
  for (const auto& [number, pinned] : pins_) digests.insert(pinned.begin(), pinned.end());
  return digests;
}

std::set<Digest> PinBoard::Held::pinned() const {
  std::set<Digest> digests = board_.own();
  for (const fs::directory_entry& entry : fs::directory_iterator(board_.folder_ / "pins")) {
    if (entry.path() == board_.own_path_) continue;
    try {
      File file(entry.path(), O_RDWR);
      if (file.try_lock()) {  // its process is gone
        fs::remove(entry.path());
        continue;
      }
      std::istringstream lines(read_text_file(entry.path(), 64 * limits::MiB));
      for (std::string line; std::getline(lines, line);)
        if (const auto digest = Digest::from_hex(line)) digests.insert(*digest);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::not_found) throw;  // a process took its file away meanwhile
    }
  }
  return digests;
}

}  // namespace tessera::assets

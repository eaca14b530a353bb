#pragma once
#include <cstdint>
#include <random>
#include <string>

namespace tessera::fuzz {

/// Changes bytes as files get broken, and as those who mean harm change them: bits and bytes,
/// fields that say how many, pieces cut out, doubled, moved or cut off. The same generator gives
/// the same changes on every machine.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  /// Of what `one` holds, one to four changes; `other` is an input from which pieces may come. At
  /// most `most` bytes.
  std::string mutant(const std::string& one, const std::string& other, std::size_t most);
  std::size_t below(std::size_t bound);

 private:
  void change(std::string& bytes, const std::string& other);
  void set_field(std::string& bytes);
  void set_number(std::string& bytes);
  void splice(std::string& bytes, const std::string& other);

  std::mt19937_64 random_;
};

}  // namespace tessera::fuzz

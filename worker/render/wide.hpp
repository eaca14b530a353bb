#pragma once
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

/// Numbers side by side in one register, for what many samples do alike. Each operation does in
/// each lane what it does to one number, so a formula that is written for either gives the same
/// bits in both. Where one number would take a branch, both ways are taken and select() keeps one.
namespace tessera::render {

/// The compiler's own types for a register of numbers, and of as many integers.
template <class T>
struct WideRegister;
template <>
struct WideRegister<float> {
  using Values [[gnu::vector_size(32)]] = float;
  using Bits [[gnu::vector_size(32)]] = std::int32_t;
};
template <>
struct WideRegister<double> {
  using Values [[gnu::vector_size(32)]] = double;
  using Bits [[gnu::vector_size(32)]] = std::int64_t;
};

/// One truth a lane, as wide as numbers of type T.
template <class T>
class WideMask {
 public:
  using Register = typename WideRegister<T>::Bits;

  explicit WideMask(Register bits) : bits_(bits) {}
  [[nodiscard]] Register bits() const { return bits_; }
  [[nodiscard]] bool operator[](std::size_t lane) const { return bits_[lane] != 0; }
  friend WideMask operator&(const WideMask& a, const WideMask& b) {
    return WideMask(a.bits_ & b.bits_);
  }
  friend WideMask operator^(const WideMask& a, const WideMask& b) {
    return WideMask(a.bits_ ^ b.bits_);
  }
  friend WideMask operator|(const WideMask& a, const WideMask& b) {
    return WideMask(a.bits_ | b.bits_);
  }

 private:
  Register bits_;
};

/// 8 floats or 4 doubles.
template <class T>
class Wide {
 public:
  static constexpr std::size_t lanes = 32 / sizeof(T);
  using Mask = WideMask<T>;
  using Register = typename WideRegister<T>::Values;

  Wide() = default;  ///< any numbers
  /// The same in all lanes. NOLINTNEXTLINE(google-explicit-constructor): a formula's constants
  Wide(T all) : values_(all - Register{}) {}
  explicit Wide(Register values) : values_(values) {}
  static Wide load(const T* from) {
    Wide out;
    __builtin_memcpy(&out.values_, from, sizeof out.values_);
    return out;
  }
  [[nodiscard]] Register values() const { return values_; }
  [[nodiscard]] T operator[](std::size_t lane) const { return values_[lane]; }
  void set(std::size_t lane, T value) { values_[lane] = value; }

  Wide operator-() const { return Wide(-values_); }
  friend Wide operator+(const Wide& a, const Wide& b) { return Wide(a.values_ + b.values_); }
  friend Wide operator-(const Wide& a, const Wide& b) { return Wide(a.values_ - b.values_); }
  friend Wide operator*(const Wide& a, const Wide& b) { return Wide(a.values_ * b.values_); }
  friend Wide operator/(const Wide& a, const Wide& b) { return Wide(a.values_ / b.values_); }
  Wide& operator+=(const Wide& b) { return *this = *this + b; }
  Wide& operator*=(const Wide& b) { return *this = *this * b; }
  friend Mask operator<(const Wide& a, const Wide& b) { return mask(a.values_ < b.values_); }
  friend Mask operator>(const Wide& a, const Wide& b) { return mask(a.values_ > b.values_); }
  friend Mask operator<=(const Wide& a, const Wide& b) { return mask(a.values_ <= b.values_); }
  friend Mask operator>=(const Wide& a, const Wide& b) { return mask(a.values_ >= b.values_); }

 private:
  template <class Comparison>
  static Mask mask(Comparison bits) {
    return Mask(std::bit_cast<typename Mask::Register>(bits));
  }
  Register values_;
};
using WideFloat = Wide<float>;
using WideDouble = Wide<double>;

// The same words for one number.

inline float select(bool condition, float yes, float no) { return condition ? yes : no; }
inline double select(bool condition, double yes, double no) { return condition ? yes : no; }
template <class T>
Wide<T> select(const WideMask<T>& condition, const Wide<T>& yes, const Wide<T>& no) {
  return Wide<T>(condition.bits() ? yes.values() : no.values());
}

template <class T>
std::enable_if_t<std::is_floating_point_v<T>, T> square_root(T x) {
  return std::sqrt(x);
}
inline WideFloat square_root(const WideFloat& x) {
  return WideFloat(__builtin_ia32_sqrtps256(x.values()));
}
inline WideDouble square_root(const WideDouble& x) {
  return WideDouble(__builtin_ia32_sqrtpd256(x.values()));
}

/// Whether bit `bit` of a number's representation is set.
inline bool has_bit(double x, int bit) {
  return ((std::bit_cast<std::uint64_t>(x) >> static_cast<unsigned>(bit)) & 1U) != 0;
}
inline WideDouble::Mask has_bit(const WideDouble& x, int bit) {
  using Bits = WideDouble::Mask::Register;
  const auto set = (std::bit_cast<Bits>(x.values()) & (std::int64_t{1} << bit)) != 0;
  return WideDouble::Mask(std::bit_cast<Bits>(set));
}
/// The size of one with the sign of the other.
template <class T>
std::enable_if_t<std::is_floating_point_v<T>, T> with_sign(T size, T sign) {
  return std::copysign(size, sign);
}
template <class T>
Wide<T> with_sign(const Wide<T>& size, const Wide<T>& sign) {
  using Bits = typename WideRegister<T>::Bits;
  const auto top = std::bit_cast<Bits>(Wide<T>(T(-0.0)).values());
  const Bits of_size = std::bit_cast<Bits>(size.values()) & ~top;
  const Bits of_sign = std::bit_cast<Bits>(sign.values()) & top;
  return Wide<T>(std::bit_cast<typename Wide<T>::Register>(of_size | of_sign));
}
template <class N>
N magnitude(const N& x) {
  return with_sign(x, N(1));
}

/// Towards 0, of what an int holds; of nothing else may it be asked.
inline float whole_part(float x) { return static_cast<float>(static_cast<int>(x)); }
inline WideFloat whole_part(const WideFloat& x) {
  return WideFloat(__builtin_convertvector(
      __builtin_convertvector(x.values(), WideRegister<float>::Bits), WideRegister<float>::Values));
}

/// Four floats from memory, in double.
inline WideDouble widened(const float* from) {
  using Half [[gnu::vector_size(16)]] = float;
  Half values;
  __builtin_memcpy(&values, from, sizeof values);
  return WideDouble(__builtin_convertvector(values, WideRegister<double>::Values));
}

/// std::max and std::min, of NaN too.
template <class N>
N greater(const N& a, const N& b) {
  return select(a < b, b, a);
}
template <class N>
N lesser(const N& a, const N& b) {
  return select(b < a, b, a);
}
template <class N>
N within(const N& x, const N& low, const N& high) {
  return lesser(greater(x, low), high);
}

}  // namespace tessera::render

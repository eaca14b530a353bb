#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/image/texels.hpp"
#include "common/scene/texture.hpp"

namespace tessera::render {

/// What each code of an integer format is, linear: 256 or 65536 floats, from 0 to 1.
class CodeTable {
 public:
  CodeTable(std::size_t codes, scene::ColorSpace space);

  [[nodiscard]] const float* values() const { return values_.data(); }
  /// The code whose value is nearest to `linear`.
  [[nodiscard]] std::uint16_t nearest(float linear) const;

 private:
  std::vector<float> values_;
  /// Where a search begins: for each of so many equal parts of 0…1 the first code whose value is
  /// not below it.
  std::vector<std::uint16_t> first_;
};

/// Of an integer format, made once. `space` srgb: the curve of IEC 61966-2-1.
const CodeTable& code_table(image::TexelFormat format, scene::ColorSpace space);

}  // namespace tessera::render

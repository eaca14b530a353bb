#include "common/scene/gltf/draco.hpp"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>
#include <tiny_gltf.h>

#include <exception>
#include <memory>
#include <new>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr int bitstream = DRACO_BITSTREAM_VERSION(2, 2);

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorKind::bad_input, why); }

void check_count(std::uint64_t count, const char* of, std::size_t bytes) {
  const std::uint64_t most = limits::gltf_draco_elements;
  if (count > most)
    throw Error(ErrorKind::too_large, fmt::format("{} {}; {} is the most", count, of, most));
  if (count / limits::gltf_draco_ratio > bytes)
    refuse(fmt::format("{} {} cannot come out of {} bytes: they are damaged", count, of, bytes));
}

/// Looks at what the decoder would take memory for before it looks further itself. The encoding's
/// method.
draco::MeshEncoderMethod check_start(draco::DecoderBuffer buffer, std::size_t bytes) {
  draco::DracoHeader header{};
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok())
    refuse("not a buffer of Draco's");
  if (header.encoder_type != draco::TRIANGULAR_MESH)
    refuse("Draco's bytes hold points, and no mesh");
  if (DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor) != bitstream)
    refuse(fmt::format("Draco's bitstream {}.{}; 2.2 can be read", header.version_major,
                       header.version_minor));
  buffer.set_bitstream_version(bitstream);
  draco::GeometryMetadata passed_over;
  if ((header.flags & METADATA_FLAG_MASK) != 0 &&
      !draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &passed_over))
    refuse("Draco's metadata are damaged");
  std::uint32_t first = 0, second = 0;
  std::uint8_t traversal = 0;
  const bool edgebreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
  if (!edgebreaker && header.encoder_method != draco::MESH_SEQUENTIAL_ENCODING)
    refuse(fmt::format("Draco's method {} is not known", header.encoder_method));
  if ((edgebreaker && !buffer.Decode(&traversal)) || !draco::DecodeVarint(&first, &buffer) ||
      !draco::DecodeVarint(&second, &buffer))
    refuse("Draco's bytes are cut off");
  check_count(edgebreaker ? second : first, "faces", bytes);
  check_count(edgebreaker ? first : second, "points", bytes);
  return static_cast<draco::MeshEncoderMethod>(header.encoder_method);
}

/// A decoder of the library's that goes on to the attributes' values only if they have room.
template <class Decoder>
class Bounded : public Decoder {
 protected:
  bool DecodeAllAttributes() override {
    const draco::PointCloud& cloud = *this->point_cloud();
    std::uint64_t bytes = 0;
    for (int i = 0; i < cloud.num_attributes(); ++i)
      bytes += static_cast<std::uint64_t>(cloud.attribute(i)->byte_stride());
    if (bytes * cloud.num_points() > limits::gltf_unpacked)
      throw Error(ErrorKind::too_large,
                  fmt::format("{} points of {} bytes; {} bytes are the most", cloud.num_points(),
                              bytes, limits::gltf_unpacked));
    return Decoder::DecodeAllAttributes();
  }
};

void decode(std::span<const std::byte> packed, draco::Mesh& out) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(packed.data()), packed.size());
  const draco::DecoderOptions options;
  draco::Status status;
  try {
    if (check_start(buffer, packed.size()) == draco::MESH_EDGEBREAKER_ENCODING)
      status = Bounded<draco::MeshEdgebreakerDecoder>().Decode(options, &buffer, &out);
    else
      status = Bounded<draco::MeshSequentialDecoder>().Decode(options, &buffer, &out);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    refuse(fmt::format("Draco's bytes cannot be unpacked: {}", problem.what()));
  }
  if (!status.ok())
    refuse(fmt::format("Draco's bytes cannot be unpacked: {}", excerpt(status.error_msg())));
}

std::vector<std::uint32_t> corners_of(const draco::Mesh& mesh) {
  std::vector<std::uint32_t> out;
  out.reserve(std::size_t{mesh.num_faces()} * 3);
  for (std::uint32_t face = 0; face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(face))) {
      if (corner.value() >= mesh.num_points())
        refuse(fmt::format("face {} of Draco's bytes names point {}; the last is {}", face,
                           corner.value(), mesh.num_points() - 1));
      out.push_back(corner.value());
    }
  return out;
}

template <class Number>
std::vector<std::byte> values_as(const draco::PointAttribute& from, std::uint32_t points,
                                 std::size_t components) {
  std::vector<std::byte> out(points * components * sizeof(Number));
  auto* at = reinterpret_cast<Number*>(out.data());
  for (std::uint32_t point = 0; point < points; ++point, at += components) {
    const draco::AttributeValueIndex index = from.mapped_index(draco::PointIndex(point));
    const std::int64_t end = from.GetBytePos(index) + from.byte_stride();
    if (index.value() >= from.size() || end > static_cast<std::int64_t>(from.buffer()->data_size()))
      refuse(fmt::format("point {} of Draco's bytes has no value", point));
    if (!from.ConvertValue<Number>(index, static_cast<std::int8_t>(components), at))
      refuse(fmt::format("a value of point {} of Draco's bytes is beyond its type", point));
  }
  return out;
}

std::vector<std::byte> values_of(const draco::Mesh& mesh, const DracoAttribute& wanted) {
  const draco::PointAttribute* const from = mesh.GetAttributeByUniqueId(wanted.id);
  if (from == nullptr) refuse(fmt::format("Draco's bytes have no attribute {}", wanted.id));
  const std::size_t components = from->num_components();
  if (components != wanted.components)
    refuse(fmt::format("attribute {} of Draco's bytes has {} numbers an element, not {}", wanted.id,
                       components, wanted.components));
  const bool fractions = from->data_type() == draco::DT_FLOAT32;
  if (!fractions && !draco::IsDataTypeIntegral(from->data_type()))
    refuse(fmt::format("attribute {} of Draco's bytes has neither integers nor floats", wanted.id));
  if (fractions && wanted.component_type != TINYGLTF_COMPONENT_TYPE_FLOAT)
    refuse(fmt::format("attribute {} of Draco's bytes has floats, and its accessor integers",
                       wanted.id));
  const std::uint32_t points = mesh.num_points();
  switch (wanted.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return values_as<std::int8_t>(*from, points, components);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return values_as<std::uint8_t>(*from, points, components);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return values_as<std::int16_t>(*from, points, components);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return values_as<std::uint16_t>(*from, points, components);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return values_as<std::uint32_t>(*from, points, components);
    default:
      return values_as<float>(*from, points, components);
  }
}

}  // namespace

DracoMesh decode_draco(std::span<const std::byte> packed, std::span<const DracoAttribute> wanted) {
  draco::Mesh mesh;
  decode(packed, mesh);
  std::uint64_t bytes = 0;
  for (const DracoAttribute& one : wanted) bytes += one.components * sizeof(float);
  if (bytes * mesh.num_points() > limits::gltf_unpacked)
    throw Error(ErrorKind::too_large, fmt::format("{} points of {} bytes; {} bytes are the most",
                                                  mesh.num_points(), bytes, limits::gltf_unpacked));
  DracoMesh out{.points = mesh.num_points(), .corners = corners_of(mesh), .attributes = {}};
  for (const DracoAttribute& one : wanted) out.attributes.push_back(values_of(mesh, one));
  return out;
}

}  // namespace tessera::scene::gltf

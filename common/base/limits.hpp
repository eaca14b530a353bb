#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

/// Every bound on what comes from outside, in one place, but for what one reader alone knows of:
/// the ranges of a scene's single numbers stand with its fields, lengths of texts in messages with
/// their codec. A bound is checked before anything is allocated or started.
namespace tessera::limits {

constexpr std::size_t KiB = 1024;
constexpr std::size_t MiB = 1024 * KiB;
constexpr std::size_t GiB = 1024 * MiB;

// The film and its plan.
constexpr int film_side_max = 65536;                   ///< pixels
constexpr std::int64_t film_pixels_max = 512LL << 20;  ///< pixels in one frame
constexpr std::int64_t samples_max = 1 << 24;          ///< samples of a pixel
constexpr int tile_side_min = 1;
constexpr int tile_side_max = 512;
constexpr int pass_samples_max = 1024;
constexpr std::int64_t tasks_max = 64LL << 20;  ///< tasks of one job
constexpr int bounces_max = 1024;
constexpr int light_samples_max = 1024;
constexpr double pixel_aspect_min = 0.01;
constexpr double pixel_aspect_max = 100;
constexpr double clamp_max = 1e30;       ///< the most that light may be clamped to
constexpr double filter_width_max = 64;  ///< pixels
constexpr std::size_t aovs_max = 64;     ///< that a job may name
/// The names of a job's mattes as JSON. It is read by whoever asks for the job, and kept by the
/// coordinator.
constexpr std::size_t matte_names_bytes = 96 * KiB;

// A job, beside its film.
constexpr std::int32_t frame_max = 1'000'000;  ///< a frame's number, and its negative the least
constexpr std::size_t frame_ranges_max = 1000;
constexpr double fps_min = 0.001;
constexpr double fps_max = 10'000;
constexpr int priority_max = 100;                      ///< and its negative the least
constexpr std::int64_t job_workers_max = 1'000'000;    ///< that a job may be held to
constexpr double time_limit_max = 365.25 * 24 * 3600;  ///< seconds
constexpr double noise_max = 1000;                     ///< threshold at which a job ends

// The wire.
constexpr std::size_t wire_header_before_welcome = 4 * KiB;
constexpr std::size_t wire_header = 256 * KiB;
constexpr std::size_t wire_body = 64 * MiB;
constexpr std::size_t wire_chunk = 64 * KiB;
constexpr std::size_t workers_max = 16384;         ///< connections to the workers' port
constexpr std::chrono::seconds handshake_time{5};  ///< from the connection to `hello`
constexpr std::chrono::seconds frame_time{30};     ///< from a frame's first byte to its last

// HTTP.
constexpr std::size_t http_connections_max = 4096;
constexpr std::size_t http_header = 16 * KiB;
constexpr std::size_t http_json_body = 4 * MiB;
constexpr std::chrono::seconds http_idle_time{60};
constexpr std::chrono::seconds http_write_time{30};  ///< a client that does not read is cut off
constexpr std::size_t event_backlog = 1024;          ///< events kept for a listener that is slow

// Assets.
constexpr std::size_t blob_bytes = 16 * GiB;
constexpr std::size_t bundle_files = 65536;
constexpr std::size_t bundle_json_bytes = 128 * MiB;
constexpr std::size_t bundle_path = 1024;  ///< bytes of a path within a bundle

// Scene files.
constexpr std::size_t scene_json_bytes = 512 * MiB;
constexpr int json_depth = 64;
constexpr std::size_t mesh_vertices = 1U << 30;
constexpr std::size_t mesh_triangles = 1U << 30;
constexpr std::size_t mesh_file_bytes = 8 * GiB;  ///< OBJ, PLY
constexpr std::size_t polygon_corners = 256;      ///< of a face: OBJ, PLY
/// Each face holds the number of its material in 16 bits.
constexpr std::size_t materials_max = 65536;
/// Faces that are sampled as lights, instances counted; a worker keeps some 220 bytes for each.
constexpr std::size_t light_faces = 8U << 20;

// glTF files, beside these.
constexpr std::size_t gltf_values = 4U << 20;  ///< keys and values of its JSON
constexpr std::size_t gltf_zeros = 16U << 20;  ///< elements of an accessor that no bytes stand for
constexpr std::size_t gltf_unpacked = GiB;     ///< of one compressed buffer view or mesh
constexpr std::size_t gltf_draco_elements = 16U << 20;  ///< faces, and points, of one buffer
constexpr std::size_t gltf_draco_ratio = 4096;          ///< of them, to a compressed byte
constexpr std::size_t gltf_made = 512 * MiB;            ///< bytes of numbers and places, in all;
constexpr std::size_t gltf_made_ratio = 64;  ///< and so many more for each byte of its buffers
constexpr std::size_t gltf_instances = 16U << 20;
constexpr int gltf_node_depth = 4096;  ///< nodes above a node

// Textures: of each picture, but the last.
constexpr int image_side = 65536;         ///< texels
constexpr std::size_t image_bytes = GiB;  ///< unpacked, in its own depth
constexpr std::size_t image_file_bytes = 4 * GiB;
constexpr std::size_t images_bytes = 64 * GiB;  ///< of a scene's together, unpacked

// Results that a worker holds until they are acknowledged.
constexpr std::size_t worker_outbox = 64 * MiB;

}  // namespace tessera::limits

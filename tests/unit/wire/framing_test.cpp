#include "common/wire/framing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "common/base/crc32c.hpp"
#include "common/base/limits.hpp"
#include "common/wire/codec.hpp"

namespace tessera::wire {
namespace {

using Bytes = std::vector<std::byte>;
constexpr std::uint16_t result_type = 9;
constexpr std::uint16_t progress_type = 7;
constexpr std::uint16_t hello_type = 1;

Bytes body_of(std::size_t size) {
  Bytes body(size);
  std::uint32_t state = 12345;
  for (std::byte& byte : body) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::byte>(static_cast<std::uint8_t>(state >> 24U));
  }
  return body;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

FrameReader reader_after_welcome() {
  FrameReader reader;
  reader.welcomed();
  return reader;
}

std::vector<Frame> read_all(FrameReader& reader, std::span<const std::byte> bytes) {
  std::vector<Frame> frames;
  while (std::optional<Frame> frame = reader.read(bytes)) frames.push_back(std::move(*frame));
  return frames;
}

FrameProblem problem_of(FrameReader& reader, std::span<const std::byte> bytes) {
  try {
    read_all(reader, bytes);
  } catch (const FrameError& error) {
    return error.problem();
  }
  ADD_FAILURE() << "the bytes were taken";
  return FrameProblem::magic;
}

Bytes text_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A frame as the table of the README has it, written independently of the encoder.
Bytes by_hand(std::uint16_t version, std::uint16_t type, std::uint32_t header_bytes,
              std::uint32_t body_bytes, const std::string& header, const Bytes& body) {
  Bytes bytes = text_bytes("TSRA");
  const auto put = [&bytes](std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i)
      bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xffU));
  };
  put(version, 2);
  put(type, 2);
  put(header_bytes, 4);
  put(body_bytes, 4);
  bytes = bytes + text_bytes(header) + body;
  put(crc32c(bytes), 4);
  return bytes;
}

TEST(Framing, a_frame_has_the_bytes_that_the_table_says) {
  const Bytes body = body_of(100);
  EXPECT_EQ(frame_bytes(result_type, "{\"a\":1}", body),
            by_hand(1, result_type, 7, 100, "{\"a\":1}", body));
  EXPECT_EQ(frame_bytes(hello_type, "{}"), by_hand(1, hello_type, 2, 0, "{}", {}));
}

TEST(Framing, a_long_body_goes_in_chunks_that_each_say_what_is_left) {
  const Bytes body = body_of(150000);
  const Bytes a(body.begin(), body.begin() + 65536);
  const Bytes b(body.begin() + 65536, body.begin() + 131072);
  const Bytes c(body.begin() + 131072, body.end());
  EXPECT_EQ(frame_bytes(result_type, "{}", body), by_hand(1, result_type, 2, 150000, "{}", a) +
                                                      by_hand(1, chunk_type, 0, 84464, "", b) +
                                                      by_hand(1, chunk_type, 0, 18928, "", c));
}

TEST(Framing, frames_come_out_the_same_wherever_the_bytes_are_cut_in_two) {
  const Bytes body = body_of(300);
  const Bytes bytes = frame_bytes(progress_type, "{\"running\":[]}") +
                      frame_bytes(result_type, "{\"x\":2}", body) + frame_bytes(progress_type, "");
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    FrameReader reader = reader_after_welcome();
    std::vector<Frame> frames = read_all(reader, std::span(bytes).first(cut));
    for (Frame& frame : read_all(reader, std::span(bytes).subspan(cut)))
      frames.push_back(std::move(frame));
    ASSERT_EQ(frames.size(), 3U) << cut;
    EXPECT_EQ(frames[0].header, "{\"running\":[]}");
    EXPECT_EQ(frames[1].type, result_type);
    EXPECT_EQ(frames[1].header, "{\"x\":2}");
    EXPECT_EQ(frames[1].body, body);
    EXPECT_EQ(frames[2].type, progress_type);
    EXPECT_FALSE(reader.in_message());
  }
}

TEST(Framing, bodies_of_every_size_about_a_chunk_survive_byte_by_byte_and_whole) {
  for (const std::size_t size : {0UL, 1UL, 65535UL, 65536UL, 65537UL, 131072UL, 131073UL}) {
    const Bytes body = body_of(size);
    const Bytes bytes = frame_bytes(result_type, "{}", body);
    for (const std::size_t step : {std::size_t{1}, std::size_t{1000}, bytes.size()}) {
      FrameReader reader = reader_after_welcome();
      std::vector<Frame> frames;
      for (std::size_t at = 0; at < bytes.size(); at += step)
        for (Frame& frame :
             read_all(reader, std::span(bytes).subspan(at, std::min(step, bytes.size() - at))))
          frames.push_back(std::move(frame));
      ASSERT_EQ(frames.size(), 1U);
      EXPECT_EQ(frames[0].body, body);
    }
  }
}

TEST(Framing, control_frames_pass_between_the_chunks_of_a_body) {
  const Bytes body = body_of(200000);
  const auto piece = [](const OutFrame& out) {
    Bytes bytes = text_bytes(out.head);
    bytes.insert(bytes.end(), out.body.begin(), out.body.end());
    bytes.insert(bytes.end(), out.crc.begin(), out.crc.end());
    return bytes;
  };
  const std::span<const std::byte> all(body);
  const Bytes beat = frame_bytes(progress_type, "{\"running\":[]}");
  const Bytes bytes = piece(first_frame(result_type, "{\"r\":1}", all)) + beat +
                      piece(chunk_frame(all.subspan(65536))) + beat + beat +
                      piece(chunk_frame(all.subspan(131072))) +
                      piece(chunk_frame(all.subspan(196608)));
  FrameReader reader = reader_after_welcome();
  const std::vector<Frame> frames = read_all(reader, bytes);
  ASSERT_EQ(frames.size(), 4U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frames[static_cast<std::size_t>(i)].type, progress_type);
  EXPECT_EQ(frames[3].type, result_type);
  EXPECT_EQ(frames[3].header, "{\"r\":1}");
  EXPECT_EQ(frames[3].body, body);
  EXPECT_EQ(reader.frames(), 7U);
}

TEST(Framing, no_truncation_gives_a_frame) {
  const Bytes bytes = frame_bytes(result_type, "{\"x\":2}", body_of(70000));
  for (std::size_t size = 0; size < bytes.size(); size += (size < 100 || size > 65000) ? 1 : 997) {
    FrameReader reader = reader_after_welcome();
    EXPECT_TRUE(read_all(reader, std::span(bytes).first(size)).empty()) << size;
    EXPECT_EQ(reader.in_message(), size > 0) << size;
  }
}

TEST(Framing, every_flipped_bit_is_an_error_or_waits_and_never_gives_the_frame) {
  const Bytes good = frame_bytes(result_type, "{\"x\":2}", body_of(64));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    FrameReader reader = reader_after_welcome();
    try {
      // A length that grew waits for what never comes.
      EXPECT_TRUE(read_all(reader, bad).empty()) << bit;
      EXPECT_TRUE(reader.in_message());
    } catch (const FrameError&) {
    }
  }
}

TEST(Framing, random_bytes_never_give_a_frame) {
  std::mt19937 random(7);
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes(random() % 64);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xffU);
    // Half of them begin well, so that what is behind the magic is reached.
    if (round % 2 == 0 && bytes.size() >= 8) {
      const Bytes begin = by_hand(1, static_cast<std::uint16_t>(random() % 17), 0, 0, "", {});
      std::copy_n(begin.begin(), 8, bytes.begin());
    }
    FrameReader reader = reader_after_welcome();
    try {
      EXPECT_TRUE(read_all(reader, bytes).empty());
    } catch (const FrameError&) {
    }
  }
}

TEST(Framing, each_fault_has_its_own_name) {
  const auto problem = [](const Bytes& bytes, bool welcomed = true) {
    FrameReader reader;
    if (welcomed) reader.welcomed();
    return problem_of(reader, bytes);
  };
  EXPECT_EQ(problem(text_bytes("GET / HTTP/1.1\r\n\r\n")), FrameProblem::http);
  EXPECT_EQ(problem(text_bytes("POST")), FrameProblem::http);
  EXPECT_EQ(problem(text_bytes("\x16\x03\x01\x02")), FrameProblem::tls);
  EXPECT_EQ(problem(text_bytes("hello there")), FrameProblem::magic);
  EXPECT_EQ(problem(by_hand(2, hello_type, 2, 0, "{}", {})), FrameProblem::version);
  EXPECT_EQ(problem(by_hand(1, 0, 2, 0, "{}", {})), FrameProblem::type);
  EXPECT_EQ(problem(by_hand(1, 16, 2, 0, "{}", {})), FrameProblem::type);
  EXPECT_EQ(problem(by_hand(1, progress_type, 2, 3, "{}", body_of(3))), FrameProblem::type);
  EXPECT_EQ(problem(by_hand(1, chunk_type, 0, 3, "", body_of(3))), FrameProblem::order);
  EXPECT_EQ(problem(by_hand(1, chunk_type, 0, 0, "", {})), FrameProblem::order);
  EXPECT_EQ(problem(by_hand(1, chunk_type, 2, 3, "{}", body_of(3))), FrameProblem::too_large);
  Bytes changed = frame_bytes(hello_type, "{\"a\":1}");
  changed[20] ^= std::byte{1};
  EXPECT_EQ(problem(changed, false), FrameProblem::crc);
  EXPECT_EQ(problem(frame_bytes(result_type, "{}", body_of(1)), false), FrameProblem::too_large);
}

TEST(Framing, a_chunk_that_does_not_go_on_where_the_body_stands_is_an_error) {
  const Bytes body = body_of(140000);
  const Bytes first =
      by_hand(1, result_type, 2, 140000, "{}", Bytes(body.begin(), body.begin() + 65536));
  FrameReader skips = reader_after_welcome();
  EXPECT_EQ(problem_of(skips, first + by_hand(1, chunk_type, 0, 8928, "", body_of(8928))),
            FrameProblem::order);
  FrameReader doubles = reader_after_welcome();
  EXPECT_EQ(problem_of(doubles, first + by_hand(1, result_type, 2, 10, "{}", body_of(10))),
            FrameProblem::order);
}

TEST(Framing, lengths_are_judged_before_a_byte_of_them_has_come) {
  const auto prefix = [](std::uint16_t type, std::uint32_t header, std::uint32_t body) {
    Bytes bytes = by_hand(1, type, header, body, "", {});
    bytes.resize(prefix_bytes);
    return bytes;
  };
  const auto judged = [&](bool welcomed, const Bytes& bytes) {
    FrameReader reader;
    if (welcomed) reader.welcomed();
    try {
      read_all(reader, bytes);
    } catch (const FrameError& error) {
      return error.problem() == FrameProblem::too_large;
    }
    return false;
  };
  const auto n = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
  EXPECT_FALSE(judged(false, prefix(hello_type, 4096, 0)));
  EXPECT_TRUE(judged(false, prefix(hello_type, 4097, 0)));
  EXPECT_TRUE(judged(false, prefix(result_type, 2, 1)));
  EXPECT_FALSE(judged(true, prefix(hello_type, n(limits::wire_header), 0)));
  EXPECT_TRUE(judged(true, prefix(hello_type, n(limits::wire_header) + 1, 0)));
  EXPECT_FALSE(judged(true, prefix(result_type, 2, n(limits::wire_body))));
  EXPECT_TRUE(judged(true, prefix(result_type, 2, n(limits::wire_body) + 1)));
  EXPECT_TRUE(judged(true, prefix(result_type, 0xffffffffU, 0xffffffffU)));
}

TEST(Framing, after_a_fault_the_reader_takes_nothing_more) {
  FrameReader reader = reader_after_welcome();
  EXPECT_EQ(problem_of(reader, text_bytes("nonsense")), FrameProblem::magic);
  EXPECT_EQ(problem_of(reader, frame_bytes(hello_type, "{}")), FrameProblem::magic);
}

}  // namespace
}  // namespace tessera::wire

#include "tests/fuzz/damage.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace tonus::fuzz {
namespace {

constexpr std::uint64_t kLongest = 4096;

}  // namespace

void Damage::apply(Bytes& bytes) {
  if (draw(0, 19) == 0) {
    bytes.resize(draw(0, std::min<std::uint64_t>(2 * bytes.size() + 64, 1U << 20U)));
    for (std::byte& octet : bytes) octet = static_cast<std::byte>(generator_());
    return;
  }
  for (std::uint64_t times = draw(1, 4); times > 0; --times) apply_one(bytes);
}

void Damage::apply_one(Bytes& bytes) {
  if (bytes.empty()) return;
  const std::uint64_t first = draw(0, bytes.size() - 1);
  const std::uint64_t length = draw(1, std::min<std::uint64_t>(kLongest, bytes.size() - first));
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(length);
  switch (draw(0, 7)) {
    case 0:
    case 1:
      for (std::uint64_t flips = draw(1, 16); flips > 0; --flips)
        bytes[draw(0, bytes.size() - 1)] ^= static_cast<std::byte>(1U << draw(0, 7));
      return;
    case 2:
      std::generate(begin, end, [this] { return static_cast<std::byte>(generator_()); });
      return;
    case 3:
      std::fill(begin, end, draw(0, 1) == 0 ? std::byte{0} : std::byte{0xFF});
      return;
    case 4:
      bytes.erase(begin, end);
      return;
    case 5:
      bytes.resize(first);
      return;
    case 6:
      bytes.insert(begin, draw(1, 64), static_cast<std::byte>(generator_()));
      return;
    default: {
      const Bytes piece(begin, end);
      const std::uint64_t to = draw(0, bytes.size() - piece.size());
      std::copy(piece.begin(), piece.end(), bytes.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
}

Bytes read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

void write_bytes(const std::string& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace tonus::fuzz

#include "tests/fuzz/decoders/decoder.hpp"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

#include "tests/support/process.hpp"

/// The decoders on good inputs, on those that were found to do harm once (tests/fuzz/corpus), and on damaged
/// ones of either. The long form, with libFuzzer, is `tests/fuzz/run`.
namespace tonus::fuzz {
namespace {

class DecoderTest : public ::testing::TestWithParam<std::string> {
 protected:
  const Decoder& decoder_ = *find_decoder(GetParam());

  std::vector<Bytes> kept() const {
    std::vector<Bytes> inputs = decoder_.seeds();
    const auto folder = testing::source_file("tests/fuzz/corpus") / GetParam();
    if (!std::filesystem::exists(folder)) return inputs;
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) inputs.push_back(read_bytes(file));
    return inputs;
  }
};

TEST_P(DecoderTest, KeepsItsPromisesOnGoodAndOnDamagedInput) {
  const auto inputs = kept();
  ASSERT_FALSE(inputs.empty());
  decoder_.run({});
  for (const auto& input : inputs) decoder_.run(input);
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    Damage damage(seed);
    Bytes input = inputs[damage.draw(0, inputs.size() - 1)];
    damage.apply(input);
    decoder_.run(input);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, DecoderTest,
    [] {
      std::vector<std::string> names;
      for (const auto& decoder : decoders()) names.emplace_back(decoder.name);
      return ::testing::ValuesIn(names);
    }(),
    [](const auto& each) { return each.param; });

}  // namespace
}  // namespace tonus::fuzz

// One program for libFuzzer and every decoder: decoder_fuzzer --target=NAME [libFuzzer's options]
// [CORPUS...].
// --list prints the names; --seeds=FOLDER writes the target's good inputs there and ends.

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "tests/fuzz/decoders/decoder.hpp"

namespace {

const tonus::fuzz::Decoder* target = nullptr;

[[noreturn]] void list() {
  for (const auto& decoder : tonus::fuzz::decoders())
    std::printf("%-10s %s\n", std::string(decoder.name).c_str(), std::string(decoder.reads).c_str());
  std::exit(0);
}

[[noreturn]] void write_seeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const auto& seed : target->seeds())
    tonus::fuzz::write_bytes((folder / ("seed-" + std::to_string(++number))).string(), seed);
  std::exit(0);
}

}  // namespace

// libFuzzer leaves options with two dashes to the program.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  std::string seeds;
  for (int i = 1; i < *argc; ++i) {
    const std::string_view word = (*argv)[i];
    if (word == "--list") list();
    if (word.starts_with("--target=")) target = tonus::fuzz::find_decoder(word.substr(9));
    if (word.starts_with("--seeds=")) seeds = word.substr(8);
  }
  if (target == nullptr) {
    std::fputs("decoder_fuzzer: --target=NAME is missing or unknown; --list has the names\n", stderr);
    std::exit(2);
  }
  if (!seeds.empty()) write_seeds(seeds);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target->run(std::as_bytes(std::span(data, size)));
  return 0;
}

// tonus-driver-contract: puts a driver library to the contract that every driver keeps, without a rig agent.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <gtest/gtest.h>

#include "rig_agent/drivers/library.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/version.hpp"
#include "tests/unit/rig_agent/drivers/driver_contract.hpp"

namespace tonus::drivers {
namespace {

struct Options {
  std::string file;
  std::string text;
};

/// Set once, before GoogleTest asks for the candidates.
Options options;

std::vector<DriverCandidate> candidates() {
  return {{"Library", [] {
             auto loaded = Library::load(options.file, options.text);
             EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().message);
             return loaded ? std::move(*loaded) : nullptr;
           }}};
}

INSTANTIATE_TEST_SUITE_P(Driver, DriverContract, ::testing::ValuesIn(candidates()),
                         [](const auto& candidate) { return candidate.param.name; });

}  // namespace
}  // namespace tonus::drivers

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Puts a driver library to the contract that every driver keeps; the device moves.",
               "tonus-driver-contract");
  app.set_version_flag("--version", runtime::kVersion);
  app.add_option("--driver-file", drivers::options.file, "the shared library")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--driver-options", drivers::options.text, "text that is handed to it");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  if (const auto loaded = drivers::Library::load(drivers::options.file, drivers::options.text); !loaded)
    return runtime::report(app.get_name(), loaded.error());
  int no_words = 1;
  ::testing::InitGoogleTest(&no_words, argv);
  return RUN_ALL_TESTS();
}

#include "tests/integration/program_run.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>

#include "tests/support/process.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{120};

std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

ProgramRun run_program(const std::string& name, const std::vector<std::string>& arguments,
                       const std::filesystem::path& folder, const std::string& shell) {
  const auto errors = folder / "errors";
  // The program's standard error alone; standard output as the shell's words have it, else the file's.
  std::vector<std::string> words{"-c", "exec 2> " + errors.string() + "; " + shell, "sh",
                                 program(name).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  Process process("/bin/sh", words, folder / "output");
  const int code = process.wait(kLimit);
  return {code > 128 ? 128 - code : code, content_of(folder / "output"), content_of(errors)};
}

bool is_refused_in_one_line(const ProgramRun& run) {
  return run.code > 0 && std::count(run.errors.begin(), run.errors.end(), '\n') == 1;
}

}  // namespace tonus::testing

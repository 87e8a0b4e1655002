#include "services/cli/answer.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "services/core/json_text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::cli {
namespace {

constexpr char kStandardOutput[] = "-";

Error refused(const char* what) {
  return fail(ErrorCode::kIo, std::string("--json -: ") + what + " failed: " + std::strerror(errno));
}

}  // namespace

void add_json_flag(CLI::App& command, bool& is_json) { command.add_flag("--json", is_json, "for programs"); }

void print_answer(bool is_json, nlohmann::json json, const std::string& text) {
  if (!is_json) {
    std::fputs(text.c_str(), stdout);
    return;
  }
  json["schema"] = 1;
  std::printf("%s\n", json_text(json).c_str());
}

Result<ResultsFile> ResultsFile::create(std::string file) {
  if (file != kStandardOutput) return ResultsFile(std::move(file), FileDescriptor());
  std::fflush(stdout);
  FileDescriptor output(fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  if (!output.is_open()) return refused("keeping standard output");
  if (dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return refused("turning to standard error");
  return ResultsFile(std::move(file), std::move(output));
}

Result<void> ResultsFile::write(const std::string& text) const {
  if (file_.empty()) return {};
  if (!output_.is_open()) return write_text_file(file_, text);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(output_.get(), text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return refused("writing");
    done += static_cast<std::size_t>(count);
  }
  return {};
}

}  // namespace tonus::cli

#include "services/cli/progress_bar.hpp"

#include <cstdio>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <utility>

namespace tonus::cli {
namespace {

constexpr std::uint64_t kWidth = 30;

}  // namespace

ProgressBar::ProgressBar(std::string title)
    : title_(std::move(title)), is_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::show(std::uint64_t done, std::uint64_t total, const std::string& remark) {
  if (!spdlog::should_log(spdlog::level::info)) return;  // --quiet
  const std::uint64_t whole = total == 0 ? 1 : total;
  if (!is_terminal_) {
    const std::uint64_t tenth = done * 10 / whole;
    if (tenth <= last_tenth_) return;
    last_tenth_ = tenth;
    std::fprintf(stderr, "%s: %llu of %llu %s\n", title_.c_str(), static_cast<unsigned long long>(done),
                 static_cast<unsigned long long>(total), remark.c_str());
    return;
  }
  const std::uint64_t filled = done * kWidth / whole;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\r\033[K%s [%s] %llu of %llu %s", title_.c_str(), bar.c_str(),
               static_cast<unsigned long long>(done), static_cast<unsigned long long>(total), remark.c_str());
  std::fflush(stderr);
  is_drawn_ = true;
}

void ProgressBar::say(const std::string& line) {
  clear();
  std::fprintf(stderr, "%s\n", line.c_str());
}

void ProgressBar::clear() {
  if (!is_drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  is_drawn_ = false;
}

}  // namespace tonus::cli

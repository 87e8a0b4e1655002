#pragma once

#include <string>

namespace tonus::runtime {

struct CommonOptions;

/// The program's log from here on. On standard error, a line an event: date, time and zone, level, program,
/// text. Where standard error is the journal of systemd, entries of it with the fields PRIORITY,
/// SYSLOG_IDENTIFIER, TONUS_RIG and TONUS_DOMAIN instead.
///
/// SIGRTMIN+22 lowers the level to debug while the program runs, SIGRTMIN+23 sets it back (the numbers that
/// systemd itself uses: `systemctl kill --signal=RTMIN+22 tonus-archive`).
void start_log(const std::string& program, const CommonOptions& options);

/// The same for a command that is of no rig and domain.
void start_log(const std::string& program, const std::string& level);

/// Whether standard error is the journal: JOURNAL_STREAM names its device and inode (systemd.exec(5)).
[[nodiscard]] bool is_logged_by_journal();

}  // namespace tonus::runtime

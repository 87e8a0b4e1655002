#include "services/cli/current_session.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/contract/names.hpp"

namespace tonus::cli {

Result<v1::SessionState> current_session(OperatorConnection& end, const runtime::CommonOptions& common) {
  constexpr std::chrono::seconds kLook{2};
  SessionClient& client = end.client();
  // What has ended is heard of, too, and maybe first.
  const auto goes_on = [&] { return client.newest_state() && !v1::is_over(client.newest_state()->phase()); };
  const bool is_heard = client.wait_for(goes_on, kLook, [&] { return end.is_interrupted(); }).has_value();
  if (end.is_interrupted()) return fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText));
  if (!is_heard && !client.newest_state()) {
    const bool is_up = !client.roster().present().empty();
    if (is_up && !client.roster().find(v1::ROLE_SCHEDULER)) {
      return fail(
          ErrorCode::kUnavailable,
          fmt::format("no scheduler was heard of in domain {} within {} s: nothing is known of a session",
                      common.domain, kLook.count()));
    }
    return fail(ErrorCode::kNotFound,
                fmt::format("there is no session in domain {}; {}", common.domain,
                            is_up ? "`tonus run PROTOCOL` starts one" : kServicesNotUp));
  }
  return *client.newest_state();
}

}  // namespace tonus::cli

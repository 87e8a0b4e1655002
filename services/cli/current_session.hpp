#pragma once

#include "services/cli/operator_connection.hpp"

namespace tonus::cli {

/// The session that goes on, or where there is none the one that has ended; waits 2 s for it. kNotFound says
/// what to type; kUnavailable: Ctrl-C.
[[nodiscard]] Result<v1::SessionState> current_session(OperatorConnection& end,
                                                       const runtime::CommonOptions& common);

/// What to do where no service answers.
inline constexpr const char* kServicesNotUp =
    "`tonus up` starts the services of this machine, `tonus doctor` says what is missing";

}  // namespace tonus::cli

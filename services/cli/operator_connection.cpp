#include "services/cli/operator_connection.hpp"

#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/core/name.hpp"
#include "services/runtime/security.hpp"

namespace tonus::cli {
namespace {

const std::vector<v1::ServiceRole> kNeeded{v1::ROLE_RIG, v1::ROLE_SCHEDULER, v1::ROLE_IDENTIFICATION,
                                           v1::ROLE_ARCHIVE};

}  // namespace

Result<std::unique_ptr<OperatorConnection>> OperatorConnection::join(const runtime::CommonOptions& options) {
  std::unique_ptr<OperatorConnection> end(new OperatorConnection);
  end->stop_ = std::make_unique<StopSignal>([notifier = end->notifier_] { notifier->notify(); });
  auto bus = runtime::open_bus(options, "tonus");
  if (!bus) return bus.error();
  end->bus_ = std::move(*bus);
  auto client = SessionClient::create(*end->bus_, end->clock_, end->notifier_, runtime::may_command(options));
  if (!client) return client.error();
  end->client_.emplace(std::move(*client));
  end->rig_ = options.rig;
  return end;
}

std::string OperatorConnection::held() const {
  const auto& state = client_->rig_state(rig_id(rig_));
  if (!state || state->mode() != v1::RIG_HELD) return {};
  return fmt::format(
      "rig '{}' is held: {}. When it is safe, type: tonus clear-fault; then, in a session: tonus resume",
      rig_, state->held_because().empty() ? state->fault() : state->held_because());
}

bool OperatorConnection::is_complete_but_for_the_hold() {
  auto& roster = client_->roster();
  return !held().empty() && roster.missing({v1::ROLE_RIG}, false).empty() &&
         roster.missing({v1::ROLE_SCHEDULER, v1::ROLE_IDENTIFICATION, v1::ROLE_ARCHIVE}).empty();
}

Result<void> OperatorConnection::wait_for_roster(const std::function<Result<void>()>& tick) {
  const auto deadline = clock_.now() + kRosterLimit;
  const auto is_complete = [this] { return client_->roster().missing(kNeeded).empty(); };
  while (
      !client_->wait_for(is_complete, std::chrono::milliseconds(100), [this] { return is_interrupted(); })) {
    if (is_interrupted()) return fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText));
    if (is_complete_but_for_the_hold()) return fail(ErrorCode::kUnavailable, held());
    if (tick) {
      if (auto ticked = tick(); !ticked) return ticked;
    }
    if (clock_.now() >= deadline) {
      return fail(ErrorCode::kTimeout,
                  fmt::format("after {:.0f} s: {}", std::chrono::duration<double>(kRosterLimit).count(),
                              client_->roster().missing(kNeeded)));
    }
  }
  return {};
}

}  // namespace tonus::cli

#pragma once

#include <deque>
#include <map>
#include <vector>

#include "services/core/clock.hpp"
#include "services/dashboard/gateway/operator_request.hpp"

namespace tonus::dashboard {

/// Operators' requests on their way: each is sent again until its reply comes or its time is over, and each
/// is answered. No bus, no thread: what is to be sent and answered comes back from the calls.
class OperatorDesk {
 public:
  struct Patience {
    std::chrono::milliseconds repeat{500};
    std::chrono::milliseconds repeat_stop{100};  ///< Of an emergency stop.
    std::chrono::milliseconds limit{15000};
    /// A pause or an abort is answered when the running trial has ended.
    std::chrono::milliseconds limit_of_pause{120000};
  };

  struct Effects {
    std::vector<OperatorCommand> commands;  ///< Emergency stops first.
    std::vector<OperatorReply> replies;
  };

  OperatorDesk(Patience patience, const Clock& clock) : patience_(patience), clock_(clock) {}

  /// A request with the id of one that waits changes nothing; one that has been answered is answered again.
  [[nodiscard]] Effects ask(OperatorRequest request);

  /// A reply from the bus; one to a request of somebody else changes nothing.
  [[nodiscard]] Effects on_reply(const Id& request, bool is_done, const std::string& message);

  /// Repeats what is due, gives up what is over.
  [[nodiscard]] Effects tick();

  /// When tick() has something to do next.
  [[nodiscard]] Clock::TimePoint due() const;

  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  struct Waiting {
    OperatorRequest request;
    Clock::TimePoint send_at;
    Clock::TimePoint give_up_at;
  };
  void finish(Effects& effects, const Waiting& waiting, bool is_done, const std::string& message);

  Patience patience_;
  const Clock& clock_;
  std::map<Id, Waiting> waiting_;
  std::deque<OperatorReply> answered_;  ///< The last ones, for requests that come again.
};

}  // namespace tonus::dashboard

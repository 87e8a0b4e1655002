#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "services/bus/typed.hpp"
#include "services/core/id.hpp"
#include "tests/fault/simulator/network.hpp"

#include <idl/rig.h>
#include <idl/session.h>

namespace tonus::simulator {

/// A person at the operator's page: starts the session, clears a rig that is held, then resumes; each as
/// often as it takes. A task of a life of its own, which nothing befalls.
class Operator {
 public:
  /// `granted` is told just before each word that lets the rig move.
  Operator(Network& network, std::shared_ptr<Life> life, Random& random, std::string protocol,
           std::function<void()> granted);

  Time step();

  /// Acts of the scenario.
  void stop() {
    stops_left_ = 100;
    stop_id_ = new_id();
  }
  void pause() { wants_pause_ = true; }
  void abort() { wants_abort_ = true; }

  [[nodiscard]] const std::optional<v1::SessionState>& session() const { return session_; }
  [[nodiscard]] const std::optional<v1::RigState>& rig() const { return rig_; }
  [[nodiscard]] bool is_over() const;
  [[nodiscard]] const Id& session_id() const { return session_id_; }

 private:
  [[nodiscard]] Id new_id();
  void hear();
  void act();
  void repeat_stop();
  void ask(v1::SessionRequest request);
  void clear();

  std::shared_ptr<Life> life_;
  Random& random_;
  const std::string protocol_;
  const std::function<void()> granted_;
  std::unique_ptr<bus::Bus> bus_;
  bus::TypedWriter<v1::SessionCommand> commands_;
  bus::TypedWriter<v1::RigCommand> rig_commands_;
  bus::TypedWriter<v1::RigStop> stops_;
  bus::TypedReader<v1::SessionState> states_;
  bus::TypedReader<v1::RigState> rig_states_;
  bus::TypedReader<v1::RigStop> stopped_;
  std::optional<v1::SessionState> session_;
  std::optional<v1::RigState> rig_;
  Id session_id_{};
  Id stop_id_{};
  int stops_left_ = 0;
  bool wants_pause_ = false;
  bool wants_abort_ = false;
  Time act_at_{};
};

}  // namespace tonus::simulator

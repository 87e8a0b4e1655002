#include "services/contract/trial.hpp"

namespace tonus::contract {

v1::TrialProgram new_program(v1::TrialKind kind, const TrialPlace& place) {
  v1::TrialProgram program;
  program.kind(kind);
  program.posture(place.posture);
  program.posture_index(place.posture_index);
  program.posture_m({place.position[0], place.position[1]});
  program.set_number(1);
  program.recording_index(-1);
  program.recording_event(-1);
  return program;
}

}  // namespace tonus::contract

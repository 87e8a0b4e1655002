#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis_service/spectral/record.hpp"

namespace tonus::campaigns {

/// A kind of continuous record with known truth.
struct RecordKind {
  std::string name;
  bool is_described = false;  ///< By the model M, B, K with a lag: such a record should come out right.
};

/// All kinds, in the order in which they are reported.
[[nodiscard]] const std::vector<RecordKind>& record_kinds();

/// Records of one arm or joint, and its impedance for small motion about the mean position.
struct DrawnRecords {
  std::vector<spectral::Record> records;
  Eigen::MatrixXd M, B, K;
  Eigen::VectorXd lag;                     ///< s, of the force.
  std::vector<Eigen::MatrixXd> commanded;  ///< By record: the force that drove the rig, without noise.
};

/// Draws one record of a kind: rates 100 to 5000 Hz, resonance, damping ratio, scales, durations and noise at
/// random. Motion and force are synthesised in the frequency domain with a period of twice the record, so
/// that they are exact samples of continuous signals. The same kind and seed give the same record.
[[nodiscard]] DrawnRecords draw(const RecordKind& kind, std::uint64_t seed);

}  // namespace tonus::campaigns

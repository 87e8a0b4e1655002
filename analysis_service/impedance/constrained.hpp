#pragma once

#include "analysis_service/impedance/identification.hpp"
#include "services/core/result.hpp"

namespace tonus::impedance {

/// Damping refitted with mass and stiffness held (method, section 4).
struct ConstrainedDamping {
  AxisMatrix B;      ///< N s/m.
  AxisVector X0;     ///< m, refitted with it.
  AxisVector sigma;  ///< N, (16).
  double change =
      0.0;  ///< Largest change of an element of B over the largest element of the unconstrained B.
};

/// Refits B (and the constant -K X0) of model (3) to the data behind `estimate`, M and K held at the values
/// given. It works on the estimate's information, which stands for all samples: the same result as from the
/// samples. Published: M from the link masses, K from the unconstrained fit, a change under 5 %. Errors
/// (kInvalidArgument): an estimate that is undetermined or of another model, matrices of another size.
[[nodiscard]] Result<ConstrainedDamping> constrain(const Estimate& estimate, const AxisMatrix& M,
                                                   const AxisMatrix& K);

}  // namespace tonus::impedance

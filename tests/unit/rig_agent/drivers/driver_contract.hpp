#pragma once

#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "rig_agent/drivers/driver.hpp"

namespace tonus::drivers {

struct DriverCandidate {
  std::string name;
  std::function<std::unique_ptr<Driver>()> make;
};

/// What every driver must do, whatever stands behind it (rig_agent/drivers/driver.hpp). A program that links
/// driver_contract.cpp instantiates the suite with its own drivers.
class DriverContract : public ::testing::TestWithParam<DriverCandidate> {
 protected:
  static constexpr double kPeriod = 0.001;

  void activate() {
    ASSERT_TRUE(driver_->configure(kPeriod));
    ASSERT_TRUE(driver_->activate());
    driver_->begin_trial(TrialNotice{{{0.30, -0.03}, 0.0}, {0.0, 0.38}, 0});
  }

  std::unique_ptr<Driver> driver_ = GetParam().make();
};

}  // namespace tonus::drivers

#include "services/simulation/instruction.hpp"

#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "services/simulation/true_impedance.hpp"

namespace tonus::simulation {
namespace {

const Eigen::Vector2d kHand(0.0, 0.38);

CartesianImpedance told(const char* name, const SubjectProfile& subject = {}) {
  return true_impedance(subject, kHand, instruction_named(name));
}

TEST(Instruction, IsUnderstoodByItsName) {
  EXPECT_EQ(instruction_named("relax").kind, Instruction::Kind::kRelax);
  EXPECT_EQ(instruction_named("stiffen").kind, Instruction::Kind::kStiffen);
  EXPECT_EQ(instruction_named("stiffen_x").direction, 0.0);
  EXPECT_DOUBLE_EQ(instruction_named("stiffen_y").direction, std::numbers::pi / 2.0);
  EXPECT_DOUBLE_EQ(instruction_named("stiffen_30").direction, std::numbers::pi / 6.0);
  EXPECT_DOUBLE_EQ(instruction_named("stiffen_-90").direction, -std::numbers::pi / 2.0);
}

TEST(Instruction, OfAnotherNameChangesNothing) {
  for (const char* name :
       {"", "hold", "stiffen_", "stiffen_up", "stiffen_30deg", "relaxed", "stiffen_9999999999"}) {
    EXPECT_EQ(instruction_named(name).kind, Instruction::Kind::kNone) << name;
    EXPECT_EQ(told(name).stiffness, told("").stiffness) << name;
  }
}

TEST(Instruction, ToRelaxLeavesAShareOfStiffnessAndDamping) {
  const SubjectProfile subject;
  EXPECT_TRUE(told("relax").stiffness.isApprox(subject.instruction.relaxed * told("").stiffness));
  EXPECT_TRUE(told("relax").damping.isApprox(subject.instruction.relaxed * told("").damping));
  EXPECT_EQ(told("relax").mass, told("").mass);
}

TEST(Instruction, ToStiffenMultipliesTheStiffnessAndKeepsTheDampingRatio) {
  const SubjectProfile subject;
  EXPECT_TRUE(told("stiffen").stiffness.isApprox(subject.instruction.stiffened * told("").stiffness));
  EXPECT_TRUE(told("stiffen").damping.isApprox(std::sqrt(subject.instruction.stiffened) * told("").damping));
}

TEST(Instruction, ToStiffenAlongADirectionDoesSoThereAndNotAcross) {
  const SubjectProfile subject;
  for (const double degrees : {0.0, 30.0, 90.0, 200.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across(-along.y(), along.x());
    const std::string name = "stiffen_" + std::to_string(static_cast<int>(degrees));
    const auto before = told("");
    const auto after = told(name.c_str());
    const double factor = subject.instruction.stiffened;
    EXPECT_NEAR(along.dot(after.stiffness * along), factor * along.dot(before.stiffness * along), 1e-9)
        << degrees;
    EXPECT_NEAR(across.dot(after.stiffness * across), across.dot(before.stiffness * across), 1e-9) << degrees;
    EXPECT_NEAR(across.dot(after.stiffness * along), across.dot(before.stiffness * along), 1e-9) << degrees;
    EXPECT_NEAR(along.dot(after.damping * along), std::sqrt(factor) * along.dot(before.damping * along),
                1e-9);
  }
}

TEST(Instruction, IsNotFollowedBySubjectsWhoDoNot) {
  SubjectProfile subject;
  subject.instruction.is_on = false;
  EXPECT_EQ(told("stiffen_x", subject).stiffness, told("", subject).stiffness);
}

}  // namespace
}  // namespace tonus::simulation

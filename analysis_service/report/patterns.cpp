#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/constrained.hpp"
#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/report/loaded_table.hpp"
#include "analysis_service/report/tables.hpp"
#include "analysis_service/report/tally.hpp"
#include "analysis_service/study/units.hpp"

namespace tonus::report {
namespace {

using impedance::Hypothesis;
using impedance::Method;
using Matrix = impedance::AxisMatrix;

/// Calls `use` with every unloaded condition that has a state-variable estimate.
template <typename Use>
void for_each_posture(const study::Study& study, const Use& use) {
  for (const study::Subject& subject : study.subjects) {
    if (!subject.unloaded) continue;
    for (const study::ConditionAnalysis& condition : subject.unloaded->conditions) {
      if (const auto* estimate = condition.find()) use(subject, condition, *estimate);
    }
  }
}

void add_row(Table& table, const std::string& what, const std::string& published, const std::string& found) {
  table.rows.push_back({what, published, found});
}

void add_curl(Table& table, const study::Study& study) {
  struct Kind {
    const char* name;
    Matrix impedance::Parameters::*matrix;
    const char* published;
  };
  const std::array kinds{
      Kind{"curl of stiffness", &impedance::Parameters::K, "80 % below 10 %, 90 % below 15 %, at most 25 %"},
      Kind{"curl of mass", &impedance::Parameters::M, "95 % below 15 %, at most 25 %"},
      Kind{"curl of damping", &impedance::Parameters::B, "75 % below 15 %, at most 25 %"}};
  for (const Kind& kind : kinds) {
    Share below10;
    Share below15;
    Spread spread;
    for_each_posture(
        study, [&](const study::Subject&, const study::ConditionAnalysis&, const impedance::Estimate& e) {
          const auto curl = impedance::curl_of(e.value.*kind.matrix);
          if (!curl) return;
          below10.add(curl->p_mean < 0.10);
          below15.add(curl->p_mean < 0.15);
          spread.add(100.0 * curl->p_mean);
        });
    add_row(table, kind.name, kind.published,
            fmt::format("{} below 10 %, {} below 15 %, at most {:.0f} %", below10.text(), below15.text(),
                        std::max(0.0, spread.most)));
  }
}

void add_orientation(Table& table, const study::Study& study) {
  Spread clockwise;  // per subject
  Share between;
  Share apart;
  for (const study::Subject& subject : study.subjects) {
    if (!subject.unloaded) continue;
    Spread own;
    for (const auto& condition : subject.unloaded->conditions) {
      const auto* e = condition.find();
      if (e == nullptr) continue;
      const auto mass = impedance::ellipse_of(e->value.M);
      const auto damping = impedance::ellipse_of(e->value.B);
      const auto stiffness = impedance::ellipse_of(e->value.K);
      if (!mass || !damping || !stiffness) continue;
      const double whole = impedance::rotation_between(mass->orientation, stiffness->orientation);
      const double part = impedance::rotation_between(mass->orientation, damping->orientation);
      own.add(-study::kDegrees * whole);
      between.add(part * whole > 0.0 && std::abs(part) < std::abs(whole));
      apart.add(std::abs(impedance::rotation_between(stiffness->orientation, damping->orientation)) *
                    study::kDegrees >
                5.0);
    }
    if (own.count > 0) clockwise.add(own.mean());
  }
  add_row(table, "stiffness turned clockwise from mass, mean of each subject", "22 to 39 deg",
          clockwise.text(" deg", 0));
  add_row(table, "damping between mass and stiffness in orientation", "more than 80 %", between.text());
  add_row(table, "damping turned from stiffness by more than 5 deg", "67 %", apart.text());
}

void add_shape(Table& table, const study::Study& study) {
  Spread proximal;
  Spread distal;
  Spread centre;
  for_each_posture(
      study, [&](const study::Subject&, const study::ConditionAnalysis& c, const impedance::Estimate& e) {
        centre.add(study::kMillimetres * e.value.X0.norm());
        const auto ellipse = impedance::ellipse_of(e.value.K);
        if (!ellipse) return;
        if (c.condition.posture == "proximal") proximal.add(ellipse->shape);
        if (c.condition.posture == "distal") distal.add(ellipse->shape);
      });
  add_row(table, "shape of stiffness, proximal", "1.3 to 3.2", proximal.text("", 1));
  add_row(table, "shape of stiffness, distal", "up to 8.3", distal.text("", 1));
  add_row(table, "spring centre from the posture, unloaded", "at most 1 mm", centre.text(" mm", 2));
}

void add_methods(Table& table, const study::Study& study) {
  Spread mass;
  Spread proximal_mass;
  Spread damping;
  Spread stiffness;
  for_each_posture(
      study, [&](const study::Subject&, const study::ConditionAnalysis& c, const impedance::Estimate& e) {
        const auto apart = [&](Matrix impedance::Parameters::*which) {
          const double largest = (e.value.*which).cwiseAbs().maxCoeff();
          double most = 0.0;
          for (const Method method : {Method::kLowpass, Method::kOptimal}) {
            const auto* other = c.find(method);
            if (other == nullptr) continue;
            most = std::max(most, (other->value.*which - e.value.*which).cwiseAbs().maxCoeff() / largest);
          }
          return 100.0 * most;
        };
        (c.condition.posture == "proximal" ? proximal_mass : mass).add(apart(&impedance::Parameters::M));
        damping.add(apart(&impedance::Parameters::B));
        stiffness.add(apart(&impedance::Parameters::K));
      });
  const char* what = "largest difference of the methods, of the largest element: ";
  add_row(table, std::string(what) + "mass, proximal left out", "15 %", mass.text(" %", 1));
  add_row(table, std::string(what) + "mass, proximal", "25 %", proximal_mass.text(" %", 1));
  add_row(table, std::string(what) + "damping", "15 %", damping.text(" %", 1));
  add_row(table, std::string(what) + "stiffness", "10 %", stiffness.text(" %", 1));
}

/// Fitting errors of a model held against those of the linear one (3).
struct AgainstLinear {
  void add(double error, double linear) {
    larger.add(error > linear);
    excess.add(1e3 * (error - linear));
  }
  Share larger;
  Spread excess;  ///< mN
};

void add_models(Table& table, const study::Study& study) {
  using impedance::Model;
  AgainstLinear no_damping;
  AgainstLinear squares;
  AgainstLinear signed_squares;
  Spread gain;
  for_each_posture(study,
                   [&](const study::Subject&, const study::ConditionAnalysis& c, const impedance::Estimate&) {
                     const auto with = c.fitting_error(Model::kLinear);
                     const auto without = c.fitting_error(Model::kNoDamping);
                     const auto coriolis = c.fitting_error(Model::kCoriolis);
                     const auto squared = c.fitting_error(Model::kSquaredVelocity);
                     const auto with_sign = c.fitting_error(Model::kSignedSquaredVelocity);
                     if (!with || !without || !coriolis || !squared || !with_sign) return;
                     for (const Eigen::Index axis : {0, 1}) {
                       no_damping.add((*without)[axis], (*with)[axis]);
                       squares.add((*squared)[axis], (*with)[axis]);
                       signed_squares.add((*with_sign)[axis], (*with)[axis]);
                       gain.add(1e3 * ((*without)[axis] - (*coriolis)[axis]));
                     }
                   });
  add_row(table, "fitting error larger without damping (13) than with it (3)", "in every case",
          no_damping.larger.text());
  add_row(table, "fitting error of (13) less that of (14), Coriolis", "less than 5 mN on average",
          gain.text(" mN", 1));
  const char* comparable = "comparable; where smaller, by no more than 50 mN";
  add_row(table, "fitting error of (15), squared velocity, larger than that of (3)", "12 of 20",
          squares.larger.text());
  add_row(table, "fitting error of (15) less that of (3)", comparable, squares.excess.text(" mN", 1));
  add_row(table, "fitting error of (15) with signed squares larger than that of (3)", "12 of 20",
          signed_squares.larger.text());
  add_row(table, "fitting error of (15) with signed squares less that of (3)", comparable,
          signed_squares.excess.text(" mN", 1));
}

void add_constrained(Table& table, const study::Study& study) {
  Spread change;
  for (const study::Subject& subject : study.subjects) {
    if (!subject.unloaded) continue;
    const auto masses = subject.link_masses(Method::kStateVariable);
    if (!masses) continue;
    std::size_t i = 0;
    for (const auto& condition : subject.unloaded->conditions) {
      const auto* e = condition.find();
      if (e == nullptr) continue;
      const auto constrained = impedance::constrain(*e, masses->modelled[i++], e->value.K);
      if (constrained) change.add(100.0 * constrained->change);
    }
  }
  add_row(table, "change of damping with the modelled masses, of the largest element", "less than 5 %",
          change.text(" %", 1));
}

void add_joint_space(Table& table, const study::Study& study) {
  Spread one;
  Spread three;
  Share smallest;
  Share better;
  for (const study::Subject& subject : study.subjects) {
    const auto ss = subject.fit(Hypothesis::kSS);
    const auto ms = subject.fit(Hypothesis::kMS);
    if (!ss || !ms) continue;
    one.add(100.0 * ss->error);
    three.add(100.0 * ms->error);
    better.add(ms->error < 0.75 * ss->error);
    // A difference within two standard deviations is none.
    const double margin = 2.0 * ms->std.maxCoeff();
    smallest.add(ms->constants[2] < std::min(ms->constants[0], ms->constants[1]) - margin);
  }
  add_row(table, "% error with one constant (SS)", "14 to 35 %", one.text(" %", 0));
  add_row(table, "% error with three constants (MS)", "10 to 33 %", three.text(" %", 0));
  add_row(table, "three constants lower the error by more than a quarter", "4 of 11 subjects", better.text());
  add_row(table, "the two-joint constant is the smallest, by two standard deviations",
          "smallest in 10 of 11 subjects", smallest.text());
}

void add_loaded(Table& table, const study::Study& study) {
  Spread ratio;
  Spread turn;
  Spread shape;
  Spread size;
  Spread rotation;
  for (const study::Subject& subject : study.subjects) {
    for (const study::LoadedPosture& posture : loaded_of(subject)) {
      for (const study::LoadedSet& set : posture.sets) {
        ratio.add(set.comparison.magnitude_ratio);
        turn.add(std::abs(study::kDegrees * set.comparison.turn));
        if (!set.stiffness) continue;
        shape.add(std::max(set.stiffness->shape_ratio, 1.0 / set.stiffness->shape_ratio));
        size.add(100.0 * std::abs(set.stiffness->size_ratio - 1.0));
        if (set.stiffness->has_rotation) rotation.add(std::abs(study::kDegrees * set.stiffness->rotation));
      }
    }
  }
  add_row(table, "loaded spring centre: actual over predicted distance", "about 1, with variations",
          ratio.text("", 2));
  add_row(table, "loaded spring centre: turned from the predicted one", "fairly close", turn.text(" deg", 1));
  add_row(table, "loaded stiffness: factor of change of shape", "1.1 to 1.5", shape.text("", 2));
  add_row(table, "loaded stiffness: change of size", "up to 50 %", size.text(" %", 0));
  add_row(table, "loaded stiffness: change of orientation", "up to 20 deg", rotation.text(" deg", 1));
}

}  // namespace

Table patterns_table(const study::Study& study) {
  Table table{"patterns",
              "Published patterns and this study's",
              "State-variable filtering. Published: the paper's text, sections III to V and its Tables.",
              {"pattern", "published", "this study"},
              {}};
  add_curl(table, study);
  add_orientation(table, study);
  add_shape(table, study);
  add_methods(table, study);
  add_models(table, study);
  add_constrained(table, study);
  add_joint_space(table, study);
  add_loaded(table, study);
  return table;
}

}  // namespace tonus::report

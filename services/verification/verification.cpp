#include "services/verification/verification.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/contract/names.hpp"
#include "services/contract/review.hpp"
#include "services/store/archived_trial.hpp"
#include "services/store/sample_reader.hpp"
#include "services/verification/reidentification.hpp"

namespace tonus::verification {
namespace {

using store::Session;
using Outcome = EstimateCheck::Outcome;

template <typename T>
Result<void> drop_value(const Result<T>& result) {
  return result ? Result<void>() : result.error();
}

/// Of the verdict that holds, with an operator's review.
std::string verdict_text(const v1::TrialVerdict& given, const v1::TrialReview* review) {
  const v1::TrialVerdict verdict = contract::standing_verdict(given, review);
  if (verdict.is_valid()) return "valid";
  return verdict.detail().empty() ? "invalid" : verdict.detail();
}

class Verifier {
 public:
  Verifier(store::Store& store, const store::SessionRecord& record, const Progress& progress)
      : store_(store), record_(record), progress_(progress) {}

  Result<Verification> verify() && {
    TONUS_TRY(check_messages());
    if (found_.damaged_messages > 0) {
      problem(fmt::format("{} of {} messages are damaged; what follows from them cannot be checked",
                          found_.damaged_messages, found_.messages));
      return std::move(found_);
    }
    TONUS_TRY_ASSIGN(const auto session, store::read_session(store_, record_.session));
    for (const std::string& line : session.undecodable) problem("cannot be decoded: " + line);
    found_.is_over = session.state && v1::is_over(session.state->phase());
    TONUS_TRY(check_blocks(session));
    TONUS_TRY(check_trials(session));
    TONUS_TRY(check_certificate(session));
    TONUS_TRY(check_identification(session));
    return std::move(found_);
  }

 private:
  void problem(std::string line) { found_.problems.push_back(std::move(line)); }

  Result<void> check_messages() {
    return store_.visit_messages({{}, record_.session, {}, true}, [&](const store::Message& message) {
      ++found_.messages;
      if (const auto good = store::check(message, store_.name()); !good) {
        ++found_.damaged_messages;
        problem(good.error().message);
      }
      return Result<void>();
    });
  }

  Result<void> check_blocks(const Session& session) {
    std::set<store::StreamKey> streams;
    for (const auto& trial : session.trials) {
      if (trial.record && trial.record->has_samples) streams.insert(trial.record->stream);
    }
    TONUS_TRY_ASSIGN(const auto records, store_.streams());
    for (const auto& record : records)
      if (record.auxiliary_values > 0) has_auxiliary_.insert(record.key);
    for (const auto& stream : streams) {
      for (const bool is_auxiliary : {false, true}) {
        const store::BlockQuery query{stream, {0, store::kLargestSequence}, true, is_auxiliary};
        TONUS_TRY(store_.visit_blocks(query, [&](const store::Block& block) -> Result<void> {
          if (block.session == record_.session) check_block(block);
          return {};
        }));
      }
    }
    return {};
  }

  void check_block(const store::Block& block) {
    ++found_.blocks;
    if (const auto good = store::check(block, store_.name()); !good) {
      ++found_.damaged_blocks;
      return problem(good.error().message);
    }
    const auto content = block.is_auxiliary ? drop_value(store::decode_auxiliary_block(block))
                                            : drop_value(store::decode_block(block));
    if (!content) {
      ++found_.damaged_blocks;
      return problem(fmt::format("store '{}': {}", store_.name(), content.error().message));
    }
    if (block.is_auxiliary) auxiliary_[block.stream].add(block.range());
  }

  /// How many of a trial's samples are there with the auxiliary values of their time, where the rig has such.
  std::uint64_t count_whole(const store::TrialRecord& trial, const store::TrialSamples& samples) const {
    if (!has_auxiliary_.contains(trial.stream)) return samples.samples.size() - samples.absent;
    const auto values = auxiliary_.find(trial.stream);
    if (values == auxiliary_.end()) return 0;
    store::Coverage there;
    for (std::size_t i = 0; i < samples.is_there.size(); ++i) {
      const std::uint64_t number = trial.first_sequence + i;
      if (samples.is_there[i]) there.add({number, number + 1});
    }
    return there.common(values->second).count_in(trial.range());
  }

  Result<void> check_trials(const Session& session) {
    found_.certificate = session.certificate();
    for (const auto& trial : session.trials) {
      if (!trial.record) {
        // A session that was ended in a trial may have ended before the rig could say what became of it.
        const bool was_ended_in_it = &trial == &session.trials.back() && session.state &&
                                     session.state->phase() != v1::SESSION_COMPLETED;
        if (found_.is_over && !was_ended_in_it)
          problem(fmt::format("trial {}: was commanded but has no outcome", trial.attempt));
        continue;
      }
      TrialCheck check{trial.attempt, trial.record->certificate, trial.record->is_certified, 0, 0};
      const auto& given = check.certificate;
      if (trial.record->has_samples) {
        TONUS_TRY_ASSIGN(const auto samples, store::read_trial_samples(store_, trial));
        check.found = count_whole(*trial.record, samples);
        check.absent = samples.samples.size() - check.found;
      }
      const std::uint64_t expected = check.found + check.absent;
      if (check.is_certified && (given.expected != expected || given.received != check.found)) {
        problem(fmt::format("trial {}: its certificate has {} of {} samples, the archive {} of {}",
                            trial.attempt, given.received, given.expected, check.found, expected));
      } else if (check.absent > 0) {
        problem(fmt::format("trial {}: {} of {} samples are missing", trial.attempt, check.absent, expected));
      } else if (!check.is_certified && found_.is_over) {
        problem(fmt::format("trial {}: has no certificate", trial.attempt));
      }
      found_.trials.push_back(check);
    }
    return {};
  }

  /// The session's own certificate, where it has one, is the sum of its trials'.
  Result<void> check_certificate(const Session& session) {
    TONUS_TRY_ASSIGN(const auto all, store_.session_certificates());
    for (const auto& certificate : all) {
      if (certificate.session != record_.session || certificate.sums == session.certificate()) continue;
      problem(fmt::format("the session's certificate has {} of {} samples, its trials' {} of {}",
                          certificate.sums.received, certificate.sums.expected,
                          session.certificate().received, session.certificate().expected));
    }
    return {};
  }

  Result<void> check_identification(const Session& session) {
    if (std::none_of(session.trials.begin(), session.trials.end(), [](const auto& t) { return t.outcome; })) {
      found_.remarks.emplace_back("no trial has been run");
      return {};
    }
    const CoreChoice choice = choose_core(session);
    found_.settings = choice.is_archived ? "the archived configuration of the identification service"
                                         : "the published estimates, and defaults: no configuration of the "
                                           "identification service is archived";
    TONUS_TRY_ASSIGN(const auto again, reidentify(store_, session, choice, progress_));
    found_.remarks.insert(found_.remarks.end(), again.remarks.begin(), again.remarks.end());
    compare_verdicts(session, again);
    compare_estimates(session, choice, again);
    return {};
  }

  /// A rejection of a trial whose rows had not come yet. It stands, and costs no more than a repetition.
  static bool is_from_fewer_rows(const store::SessionTrial& trial, const v1::TrialVerdict& now) {
    return trial.verdict && !trial.verdict->value.is_valid() &&
           trial.verdict->value.missing_samples() > now.missing_samples();
  }

  void compare_verdicts(const Session& session, const Reidentification& again) {
    std::map<std::uint32_t, const v1::TrialVerdict*> by_attempt;
    for (const auto& verdict : again.verdicts) by_attempt[verdict.attempt()] = &verdict;
    for (const auto& trial : session.trials) {
      const auto now = by_attempt.find(trial.attempt);
      if (!trial.verdict && now == by_attempt.end()) continue;
      VerdictCheck check{trial.attempt, true, {}, {}};
      const v1::TrialReview* review = trial.review ? &trial.review->value : nullptr;
      if (trial.verdict) check.published = verdict_text(trial.verdict->value, review);
      if (now != by_attempt.end()) check.found = verdict_text(*now->second, review);
      check.is_equal = trial.verdict && now != by_attempt.end() &&
                       trial.verdict->value.is_valid() == now->second->is_valid() &&
                       trial.verdict->value.reasons() == now->second->reasons();
      const bool is_pending = !trial.verdict && !found_.is_over;
      if (now != by_attempt.end() && is_from_fewer_rows(trial, *now->second)) {
        found_.remarks.push_back(
            fmt::format("trial {}: rejected as '{}'; its rows came later, and it was repeated", trial.attempt,
                        check.published));
      } else if (!check.is_equal && !is_pending) {
        problem(fmt::format("trial {}: published verdict '{}', from the raw data '{}'", trial.attempt,
                            check.published.empty() ? "none" : check.published,
                            check.found.empty() ? "none" : check.found));
      }
      found_.verdicts.push_back(std::move(check));
    }
  }

  void compare_estimates(const Session& session, const CoreChoice& choice, const Reidentification& again) {
    std::map<Id, const v1::Estimate*> by_id;
    for (const auto& estimate : again.estimates) by_id[estimate.estimate_id()] = &estimate;
    for (const auto& published : store::newest_estimates(session)) {
      const auto now = by_id.find(published.estimate_id());
      const v1::Estimate* found = now == by_id.end() ? nullptr : now->second;
      found_.estimates.push_back(compare(session, choice, published, found));
      if (now != by_id.end()) by_id.erase(now);
      EstimateCheck& check = found_.estimates.back();
      if (const std::string kept = rejected_trials_of(session, published); found_.is_over && !kept.empty()) {
        check.remark = "uses what was rejected by hand: " + kept;
        problem(fmt::format("{}, {}: {}", condition_text(published), published.method(), check.remark));
        continue;
      }
      if (check.outcome == Outcome::kDiffers || check.outcome == Outcome::kNotReproduced) {
        problem(fmt::format("{}, {}: {}", condition_text(published), published.method(), check.remark));
      }
    }
    for (const auto& estimate : again.estimates) {
      if (!by_id.contains(estimate.estimate_id())) continue;
      EstimateCheck check{estimate, Outcome::kNotPublished, {}, "was not published"};
      found_.estimates.push_back(std::move(check));
      const bool must_be_there = session.state && session.state->phase() == v1::SESSION_COMPLETED;
      if (must_be_there)
        problem(fmt::format("{}, {}: was not published", condition_text(estimate), estimate.method()));
    }
  }

  /// "trial 3, trial 5": those behind the estimate that an operator rejected; empty: none.
  static std::string rejected_trials_of(const Session& session, const v1::Estimate& estimate) {
    std::string text;
    for (const store::SessionTrial& trial : session.trials) {
      if (!trial.review || !trial.review->value.is_rejected()) continue;
      const bool is_used = std::ranges::any_of(
          estimate.trials(), [&](const v1::TrialRange& used) { return used.attempt() == trial.attempt; });
      if (is_used) text += fmt::format("{}trial {}", text.empty() ? "" : ", ", trial.attempt);
    }
    return text;
  }

  /// Tries what may have been different: the trials that there were, a given filter frequency, the sign.
  EstimateCheck compare(const Session& session, const CoreChoice& choice, const v1::Estimate& published,
                        const v1::Estimate* found) {
    EstimateCheck check{published, Outcome::kEqual, {}, {}};
    if (found != nullptr) {
      check.difference = difference_of(published, *found);
      if (check.difference.is_equal) return check;
    }
    std::vector<double> signs{choice.force_sign};
    if (!choice.is_archived && published.axes() == 1) signs.push_back(-choice.force_sign);
    std::string refusal;
    for (const double sign : signs) {
      for (const bool is_given : {false, true}) {
        const auto named = reidentify_as_published(store_, session, published, sign, is_given);
        if (!named) {
          refusal = named.error().message;
          continue;
        }
        const auto difference = difference_of(published, *named);
        if (difference.is_equal) {
          check.outcome = Outcome::kEqualAsNamed;
          check.difference = difference;
          check.remark = why_as_named(published, found, is_given, sign != choice.force_sign);
          return check;
        }
        const bool is_first = found == nullptr && check.difference.where.empty();
        if (is_first || difference.largest < check.difference.largest) check.difference = difference;
      }
    }
    check.outcome = check.difference.where.empty() ? Outcome::kNotReproduced : Outcome::kDiffers;
    check.remark =
        check.outcome == Outcome::kNotReproduced
            ? "the raw data give no such estimate: " + (refusal.empty() ? "no valid trial" : refusal)
            : fmt::format("differs by {:.2g} of the largest element in {}; published by version {}",
                          check.difference.largest, check.difference.where, session.record.software_version);
    return check;
  }

  static std::string why_as_named(const v1::Estimate& published, const v1::Estimate* found,
                                  bool is_frequency_given, bool is_sign_turned) {
    std::string why = "from the trials that it names";
    if (found == nullptr) {
      why += "; all trials together give none";
    } else if (found->trials_used() != published.trials_used()) {
      why += fmt::format("; of {} trials, all that are archived are {}", published.trials_used(),
                         found->trials_used());
    }
    if (is_frequency_given)
      why += fmt::format("; filter at the given {:.4g} Hz", published.natural_frequency_Hz());
    if (is_sign_turned) why += "; force sign -1";
    return why;
  }

  store::Store& store_;
  const store::SessionRecord& record_;
  const Progress& progress_;
  std::set<store::StreamKey> has_auxiliary_;
  std::map<store::StreamKey, store::Coverage> auxiliary_;  ///< Whole blocks of the session.
  Verification found_;
};

}  // namespace

Result<Verification> verify_session(store::Store& store, const store::SessionRecord& record,
                                    const Progress& progress) {
  return Verifier(store, record, progress).verify();
}

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::kEqual:
      return "equal";
    case Outcome::kEqualAsNamed:
      return "equal as named";
    case Outcome::kDiffers:
      return "differs";
    case Outcome::kNotReproduced:
      return "not reproduced";
    case Outcome::kNotPublished:
      return "not published";
  }
  return "unknown";
}

std::string condition_text(const v1::Estimate& estimate) {
  std::string text = estimate.posture();
  if (estimate.set_number() != 0) text += fmt::format(", set {}", estimate.set_number());
  if (estimate.bias_N() != std::array<double, 2>{})
    text += fmt::format(", bias ({:.2f}, {:.2f}) N", estimate.bias_N()[0], estimate.bias_N()[1]);
  if (!estimate.instruction().empty()) text += ", '" + estimate.instruction() + "'";
  return text;
}

}  // namespace tonus::verification

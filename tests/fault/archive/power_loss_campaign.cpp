#include <algorithm>
#include <deque>

#include "idl/topics.hpp"
#include "services/archive/ingest.hpp"
#include "services/archive/wire.hpp"
#include "services/bus/typed.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/fault/archive/crash_campaign.hpp"
#include "tests/fault/archive/faulty_disk.hpp"

namespace tonus::archive::testing {
namespace {

/// About the operations of 60 trials, and of a checkpoint among them.
constexpr std::uint64_t kMostOperations = 6000;
constexpr int kMostTrials = 120;

/// An archive's core and a rig that talk to each other without a bus.
class Life {
 public:
  Life(MadeUpRig& rig, store::Store& store, std::mt19937_64& generator)
      : rig_(rig), generator_(generator), ingest_(store, clock_) {}

  Result<void> start() {
    if (auto recovered = ingest_.recover(); !recovered) return recovered;
    // What an agent does after its peer was gone: all that no receipt covers comes again.
    send(rig_.through(), rig_.next_sequence(), true);
    for (const auto& trial : rig_.trials_without_receipt())
      feed_message(topics::kTrialOutcome, rig_.outcome(trial));
    return step();
  }

  Result<void> run_trial() {
    const auto trial = rig_.next_trial();
    send(trial.range.first, trial.range.end, false);
    feed_message(topics::kTrialOutcome, rig_.outcome(trial));
    return step();
  }

 private:
  template <typename T>
  void feed_message(const bus::Topic<T>& topic, const T& value) {
    const auto payload = bus::encode(value);
    bus::Sample sample;
    sample.payload = std::make_shared<const bus::Payload>(*payload);
    std::copy_n(reinterpret_cast<const std::uint8_t*>(payload->data()) + 4, sample.key.size(),
                sample.key.begin());
    static_cast<void>(feed(ingest_, topic.spec, sample, clock_.utc_ns()));
  }

  /// In blocks of random length, some late, some twice, and some not at all.
  void send(std::uint64_t first, std::uint64_t end, bool is_resent) {
    std::deque<v1::SampleBlock> late;
    while (first < end) {
      auto block = rig_.block(first, static_cast<std::uint32_t>(generator_() % 250 + 7), is_resent);
      first += block.samples().size();
      const auto fate = generator_() % 32;
      if (fate == 0 && !is_resent) continue;
      if (fate == 1) feed_message(topics::kRigSamples, block);
      if (fate == 2) {
        late.push_back(std::move(block));
      } else {
        feed_message(topics::kRigSamples, block);
      }
    }
    for (const auto& block : late) feed_message(topics::kRigSamples, block);
  }

  Result<void> step() {
    clock_.advance(std::chrono::milliseconds(generator_() % 300 + 1));
    feed_message(topics::kRigState, rig_.state());
    const Decisions decisions = ingest_.step();
    for (const auto& receipt : decisions.trial_receipts) {
      if (auto good = rig_.receive(to_wire(receipt)); !good) return good;
    }
    for (const auto& receipt : decisions.stream_receipts) {
      if (auto good = rig_.receive(to_wire(receipt)); !good) return good;
    }
    for (const auto& request : decisions.resends) send(request.range.first, request.range.end, true);
    return {};
  }

  MadeUpRig& rig_;
  std::mt19937_64& generator_;
  ManualClock clock_;
  Ingest ingest_;
};

}  // namespace

Result<void> PowerLossCampaign::live(const std::string& file, MadeUpRig& rig) {
  FaultyDisk disk(generator()());
  // Early in a life as often as anywhere: that is where files are made and recovered.
  const std::uint64_t last = draw(0, 3) == 0 ? draw(1, 60) : draw(1, kMostOperations);
  for (std::uint64_t errors = draw(0, 1) * draw(0, 4); errors > 0; --errors)
    disk.fail_at(draw(1, last), FaultyDisk::Failure::kError);
  disk.fail_at(last, FaultyDisk::Failure::kPowerLoss);
  {
    auto store = store::SqliteStore::open(file, store::SqliteStore::Access::kWrite);
    if (!store && !disk.has_failed()) return store.error();
    if (!store) ++counts_.failed_starts;
    if (store) {
      Life life(rig, **store, generator());
      auto good = life.start();
      if (!good && !disk.has_failed()) return good;
      for (int i = 0; good && i < kMostTrials && !disk.is_off(); ++i) {
        good = life.run_trial();
        if (!good) return good;
      }
    }
  }
  counts_.disk_errors += disk.errors();
  disk.lose_power();
  return {};
}

}  // namespace tonus::archive::testing

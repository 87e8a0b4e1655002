#include <algorithm>

#include "idl/topics.hpp"
#include "services/archive/ingest.hpp"
#include "services/archive/wire.hpp"
#include "services/bus/payload.hpp"
#include "services/store/block_header.hpp"
#include "services/store/memory_store.hpp"
#include "tests/fault/archive/made_up_rig.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {
namespace {

/// So that what nonsense brings in does not add up.
constexpr int kInputsOfOneArchive = 200;

class MessageTarget final : public Target {
 public:
  MessageTarget() {
    archive::testing::MadeUpRig rig(1);
    const auto trial = rig.next_trial();
    for (const bus::TopicSpec& topic : topics::kAll) {
      if (archive::is_kept(topic)) topics_.push_back(topic);
    }
    v1::SessionPlan plan;
    plan.subject("s01");
    plan.postures().resize(3);
    v1::SessionState state;
    state.phase(v1::SESSION_COMPLETED);
    seeds_ = {*bus::encode(rig.block(0, 100, false)), *bus::encode(rig.outcome(trial)),
              *bus::encode(rig.state()), *bus::encode(plan), *bus::encode(state)};
  }

  [[nodiscard]] std::string name() const override { return "messages"; }

  Result<bool> run(Damage& damage) override {
    if (inputs_++ % kInputsOfOneArchive == 0) {
      ingest_.reset();
      store_ = std::make_unique<store::MemoryStore>();
      ingest_ = std::make_unique<archive::Ingest>(*store_, clock_);
    }
    const std::size_t seed = damage.draw(0, seeds_.size() - 1);
    Bytes bytes = seeds_[seed];
    damage.apply(bytes);
    if (auto same = compare_block_readers(bytes); !same) return same.error();
    // Most damage to what belongs there, some to what does not; the carrier drops what is no payload at all.
    const auto& topic = topics_[damage.draw(0, topics_.size() - 1)];
    bus::Sample sample;
    sample.payload = std::make_shared<const bus::Payload>(bytes);
    if (!bus::is_payload_good(bytes, bytes.size())) return true;
    sample.key = bus::payload_key(bytes);
    bool is_refused = false;
    for (const bus::TopicSpec* to : {&topic, &own_topic(seed)}) {
      if (auto fed = archive::feed(*ingest_, *to, sample, 1); !fed) {
        is_refused = true;
        if (auto good = check_message(fed.error().message); !good) return good.error();
      }
    }
    clock_.advance(std::chrono::milliseconds(damage.draw(0, 400)));
    static_cast<void>(ingest_->step());
    static_cast<void>(ingest_->status());
    return is_refused;
  }

 private:
  static const bus::TopicSpec& own_topic(std::size_t seed) {
    static const std::vector<bus::TopicSpec> kTopics{topics::kRigSamples.spec, topics::kTrialOutcome.spec,
                                                     topics::kRigState.spec, topics::kSessionPlan.spec,
                                                     topics::kSessionState.spec};
    return kTopics[seed];
  }

  /// Whatever the archive takes as a block of samples must decode when it is read again.
  static Result<void> compare_block_readers(const Bytes& bytes) {
    const auto header = store::read_block_header(bytes);
    const auto block = bus::decode<v1::SampleBlock>(bytes);
    if (!header) return check_message(header.error().message);
    if (block && block->samples().size() == header->count) return {};
    return fail(ErrorCode::kInternal, "a block is taken that does not decode");
  }

  ManualClock clock_;
  std::unique_ptr<store::MemoryStore> store_;
  std::unique_ptr<archive::Ingest> ingest_;
  std::vector<bus::TopicSpec> topics_;
  std::vector<bus::Payload> seeds_;
  int inputs_ = 0;
};

}  // namespace

std::unique_ptr<Target> make_message_target() { return std::make_unique<MessageTarget>(); }

}  // namespace tonus::fuzz

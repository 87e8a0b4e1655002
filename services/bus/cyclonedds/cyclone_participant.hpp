#pragma once

#include <dds/dds.h>
#include <memory>

#include "services/bus/partitions.hpp"

namespace tonus::bus {

/// A Cyclone DDS entity that is deleted with this object, together with all that was made in it.
class CycloneEntity {
 public:
  explicit CycloneEntity(dds_entity_t entity = 0) : entity_(entity) {}
  ~CycloneEntity();
  CycloneEntity(CycloneEntity&& other) noexcept;
  CycloneEntity& operator=(CycloneEntity&& other) noexcept;
  [[nodiscard]] dds_entity_t get() const { return entity_; }

 private:
  dds_entity_t entity_;  ///< 0 or negative: none.
};

/// A topic over CdrSertype, and the type that Cyclone uses for it.
struct CycloneTopic {
  CycloneEntity entity;
  const ddsi_sertype* type = nullptr;  ///< Lives as long as the entity.
};

/// One participant in a Cyclone domain of its own: sockets, threads and settings belong to it alone, so the
/// buses of one process do not have to agree on anything, and what they say to each other goes over the
/// network like all else. (ExternalDomainId is Cyclone's way to have several such domains appear as one.)
/// Thread-safe.
class CycloneParticipant {
 public:
  [[nodiscard]] static Result<std::shared_ptr<CycloneParticipant>> create(const BusOptions& options);

  /// The same participant, with a publisher and a subscriber in other partitions.
  [[nodiscard]] static std::shared_ptr<CycloneParticipant> beside(std::shared_ptr<CycloneParticipant> owner,
                                                                  const Partitions& partitions);

  [[nodiscard]] Result<CycloneTopic> create_topic(const TopicSpec& spec);
  [[nodiscard]] dds_entity_t get() const { return owner_ ? owner_->get() : participant_.get(); }

  /// Where writers and readers are made: in its partitions.
  [[nodiscard]] dds_entity_t publisher() const { return publisher_.get(); }
  [[nodiscard]] dds_entity_t subscriber() const { return subscriber_.get(); }

 private:
  CycloneParticipant(CycloneEntity domain, CycloneEntity participant,
                     std::shared_ptr<CycloneParticipant> owner, const Partitions& partitions);

  std::shared_ptr<CycloneParticipant> owner_;  ///< Of domain and participant; none: this one.
  CycloneEntity domain_;
  CycloneEntity participant_;
  CycloneEntity publisher_;
  CycloneEntity subscriber_;
};

/// The settings of a domain as Cyclone's XML: unicast on one interface, keys in clear, quick repair of
/// losses.
[[nodiscard]] std::string cyclone_configuration(const BusOptions& options);

}  // namespace tonus::bus

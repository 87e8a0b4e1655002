// What the gateway says of itself.

#include <nlohmann/json.hpp>

#include "services/dashboard/gateway/hub.hpp"

namespace tonus::dashboard {

std::string Hub::status_json(std::uint64_t arrival_drops) const {
  using nlohmann::json;
  json clients = json::array();
  for (const auto& [id, client] : clients_) {
    clients.push_back({{"id", id},
                       {"peer", client.peer},
                       {"role", role_name(client.role)},
                       {"connected_s", std::chrono::duration<double>(clock_.now() - client.joined).count()},
                       {"subscriptions", client.subscriptions.size()},
                       {"sent", client.outbox.sent()},
                       {"thinned", client.outbox.thinned()},
                       {"waiting_messages", client.outbox.waiting_messages()},
                       {"waiting_bytes", client.outbox.waiting_bytes()}});
  }
  return json{{"utc_ns", clock_.utc_ns()},
              {"clients", clients},
              {"thinned", thinned()},
              {"arrival_drops", arrival_drops},
              {"kept_messages", latest_.messages()},
              {"kept_bytes", latest_.bytes()},
              {"forgotten", latest_.forgotten()},
              {"refused",
               {{"connection", refused(Refused::kConnection)},
                {"malformed", refused(Refused::kMalformed)},
                {"flood", refused(Refused::kFlood)},
                {"oversized", refused(Refused::kOversized)},
                {"forbidden", refused(Refused::kForbidden)},
                {"slow", refused(Refused::kSlow)}}}}
      .dump();
}

void Hub::publish_status(std::uint64_t arrival_drops) {
  if (is_wanted(topic_named(kStatusTopic).channel.id)) fan_out_json(kStatusTopic, status_json(arrival_drops));
}

}  // namespace tonus::dashboard

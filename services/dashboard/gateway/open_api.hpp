#pragma once

#include <string_view>

namespace tonus::dashboard {

/// services/dashboard/openapi.json: what GET and the JSON WebSocket give.
extern const std::string_view kOpenApi;

}  // namespace tonus::dashboard

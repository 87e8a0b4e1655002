#include <boost/asio/ssl.hpp>
#include <boost/beast/ssl.hpp>

#include "services/core/process.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/dashboard/gateway_fixture.hpp"

namespace tonus::dashboard::testing {
namespace {

using ::testing::HasSubstr;

ServerOptions with_certificate(const std::string& certificate, const std::string& key) {
  ServerOptions options;
  options.certificate = certificate;
  options.key = key;
  return options;
}

/// A certificate of its own for localhost, made by the openssl program.
class TlsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto made =
        run_process({"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                     "-nodes", "-days", "1", "-subj", "/CN=localhost", "-addext",
                     "subjectAltName=DNS:localhost", "-keyout", key(), "-out", certificate()},
                    {});
    ASSERT_TRUE(made && made->is_success());
  }
  std::string certificate() const { return (folder_ / "certificate.pem").string(); }
  std::string key() const { return (folder_ / "key.pem").string(); }
  tonus::testing::TemporaryFolder folder_;
};

TEST_F(TlsTest, ServesOverTlsToWhoTrustsItsCertificate) {
  Gateway gateway(Access({}, {}), with_certificate(certificate(), key()));
  ASSERT_EQ(gateway.error(), "");
  asio::io_context io;
  asio::ssl::context trust(asio::ssl::context::tls_client);
  trust.load_verify_file(certificate());
  trust.set_verify_mode(asio::ssl::verify_peer);
  websocket::stream<beast::ssl_stream<beast::tcp_stream>> ws(io, trust);
  beast::get_lowest_layer(ws).connect(
      asio::ip::tcp::endpoint(asio::ip::make_address("127.0.0.1"), gateway.port()));
  ws.next_layer().handshake(asio::ssl::stream_base::client);
  ws.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
    request.set(http::field::sec_websocket_protocol, kSubprotocol);
    request.set(http::field::origin, "https://localhost");
  }));
  ws.handshake("localhost", "/");
  beast::flat_buffer buffer;
  ws.read(buffer);
  EXPECT_THAT(beast::buffers_to_string(buffer.data()), HasSubstr("serverInfo"));
}

TEST_F(TlsTest, TellsBrowsersToComeByTlsOnly) {
  Gateway gateway(Access({}, {}), with_certificate(certificate(), key()));
  asio::io_context io;
  asio::ssl::context trust(asio::ssl::context::tls_client);
  for (const char* target : {"/", "/api/gateway", "/api/sessions", "/none"}) {
    beast::ssl_stream<beast::tcp_stream> stream(io, trust);
    beast::get_lowest_layer(stream).connect(
        asio::ip::tcp::endpoint(asio::ip::make_address("127.0.0.1"), gateway.port()));
    stream.handshake(asio::ssl::stream_base::client);
    http::request<http::empty_body> request(http::verb::get, target, 11);
    request.set(http::field::host, "localhost");
    http::write(stream, request);
    beast::flat_buffer buffer;
    http::response<http::string_body> response;
    http::read(stream, buffer, response);
    EXPECT_THAT(std::string(response["Strict-Transport-Security"]), HasSubstr("max-age=")) << target;
  }
}

TEST_F(TlsTest, AHandshakeThatNeverEndsIsEnded) {
  auto options = with_certificate(certificate(), key());
  options.request_limit = std::chrono::milliseconds(300);
  Gateway gateway(Access({}, {}), options);
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(), ""));
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(), std::string("\x16\x03\x01\x20", 4)))
      << "the begin of a ClientHello of 8 kB";
}

TEST_F(TlsTest, PlainHttpGetsNoAnswerFromATlsPort) {
  Gateway gateway(Access({}, {}), with_certificate(certificate(), key()));
  EXPECT_EQ(answer_to(gateway.port(), "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").find("HTTP/1.1"),
            std::string::npos);
}

TEST_F(TlsTest, FilesThatAreNotThereAreNamed) {
  Gateway gateway(Access({}, {}), with_certificate("/none.pem", key()));
  EXPECT_THAT(gateway.error(), HasSubstr("/none.pem"));
}

}  // namespace
}  // namespace tonus::dashboard::testing

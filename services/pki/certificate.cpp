#include "services/pki/certificate.hpp"

#include <ctime>
#include <memory>
#include <openssl/asn1.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

namespace tonus::pki {
namespace {

template <auto free>
struct Free {
  template <typename T>
  void operator()(T* object) const {
    free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Revocations = std::unique_ptr<X509_CRL, Free<X509_CRL_free>>;
using Memory = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Number = std::unique_ptr<ASN1_INTEGER, Free<ASN1_INTEGER_free>>;
using Time = std::unique_ptr<ASN1_TIME, Free<ASN1_TIME_free>>;
using Document = std::unique_ptr<PKCS7, Free<PKCS7_free>>;

constexpr long kVersion3 = 2;
constexpr long kVersionOfList = 1;

/// What OpenSSL last complained about.
Error refusal(const std::string& what) {
  const char* reason = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return fail(ErrorCode::kInvalidArgument,
              what + " failed: " + (reason != nullptr ? reason : "no reason given"));
}

Memory reading(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string content(const Memory& memory) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

Result<Certificate> parse_certificate(const std::string& pem) {
  Certificate certificate(PEM_read_bio_X509(reading(pem).get(), nullptr, nullptr, nullptr));
  if (!certificate) return refusal("reading a certificate");
  return certificate;
}

Result<Key> parse_key(const std::string& pem) {
  Key key(PEM_read_bio_PrivateKey(reading(pem).get(), nullptr, nullptr, nullptr));
  if (!key) return refusal("reading a private key");
  return key;
}

Time asn1_time(UtcTime time) {
  return Time(ASN1_TIME_set(nullptr, std::chrono::system_clock::to_time_t(time)));
}

UtcTime utc_time(const ASN1_TIME* time) {
  std::tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return std::chrono::system_clock::from_time_t(timegm(&parts));
}

Number number(std::uint64_t value) {
  Number made(ASN1_INTEGER_new());
  ASN1_INTEGER_set_uint64(made.get(), value);
  return made;
}

bool add_extension(X509* certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>> extension(
      X509V3_EXT_conf_nid(nullptr, &context, kind, value));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

/// A certificate for `key` with subject and validity, not signed yet.
Certificate unsigned_certificate(const Subject& subject, EVP_PKEY* key) {
  Certificate certificate(X509_new());
  X509_set_version(certificate.get(), kVersion3);
  X509_set_serialNumber(certificate.get(), number(subject.serial).get());
  X509_set1_notBefore(certificate.get(), asn1_time(subject.begin).get());
  X509_set1_notAfter(certificate.get(), asn1_time(subject.end).get());
  X509_set_pubkey(certificate.get(), key);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate.get()), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(subject.common_name.c_str()), -1, -1, 0);
  return certificate;
}

Result<KeyPair> as_pem(X509* certificate, EVP_PKEY* key) {
  const Memory certificate_text(BIO_new(BIO_s_mem()));
  const Memory key_text(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(certificate_text.get(), certificate) != 1 ||
      PEM_write_bio_PrivateKey(key_text.get(), key, nullptr, nullptr, 0, nullptr, nullptr) != 1)
    return refusal("writing a certificate");
  return KeyPair{content(certificate_text), content(key_text)};
}

Result<Revocations> parse_revocations(const std::string& pem) {
  Revocations list(PEM_read_bio_X509_CRL(reading(pem).get(), nullptr, nullptr, nullptr));
  if (!list) return refusal("reading a list of revoked certificates");
  return list;
}

Result<std::uint64_t> serial_of(const ASN1_INTEGER* integer) {
  std::uint64_t serial = 0;
  if (ASN1_INTEGER_get_uint64(&serial, integer) != 1) return refusal("reading a serial number");
  return serial;
}

}  // namespace

Result<KeyPair> make_authority(const Subject& subject) {
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return refusal("making a key");
  const Certificate certificate = unsigned_certificate(subject, key.get());
  X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate.get()));
  const bool is_made =
      add_extension(certificate.get(), certificate.get(), NID_basic_constraints, "critical,CA:TRUE") &&
      add_extension(certificate.get(), certificate.get(), NID_subject_key_identifier, "hash") &&
      X509_sign(certificate.get(), key.get(), EVP_sha256()) > 0;
  if (!is_made) return refusal("signing the authority's certificate");
  return as_pem(certificate.get(), key.get());
}

Result<KeyPair> make_certificate(const Subject& subject, const KeyPair& authority) {
  TONUS_TRY_ASSIGN(const Certificate issuer, parse_certificate(authority.certificate));
  TONUS_TRY_ASSIGN(const Key issuer_key, parse_key(authority.key));
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return refusal("making a key");
  const Certificate certificate = unsigned_certificate(subject, key.get());
  X509_set_issuer_name(certificate.get(), X509_get_subject_name(issuer.get()));
  const bool is_made =
      add_extension(certificate.get(), issuer.get(), NID_basic_constraints, "critical,CA:FALSE") &&
      add_extension(certificate.get(), issuer.get(), NID_authority_key_identifier, "keyid") &&
      X509_sign(certificate.get(), issuer_key.get(), EVP_sha256()) > 0;
  if (!is_made) return refusal("signing a certificate");
  return as_pem(certificate.get(), key.get());
}

Result<std::string> make_revocations(const std::vector<std::uint64_t>& serials, UtcTime now,
                                     const KeyPair& authority) {
  TONUS_TRY_ASSIGN(const Certificate issuer, parse_certificate(authority.certificate));
  TONUS_TRY_ASSIGN(const Key key, parse_key(authority.key));
  const Revocations list(X509_CRL_new());
  X509_CRL_set_version(list.get(), kVersionOfList);
  X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(issuer.get()));
  X509_CRL_set1_lastUpdate(list.get(), asn1_time(now).get());
  X509_CRL_set1_nextUpdate(list.get(), X509_get0_notAfter(issuer.get()));
  for (const std::uint64_t serial : serials) {
    X509_REVOKED* revoked = X509_REVOKED_new();
    X509_REVOKED_set_serialNumber(revoked, number(serial).get());
    X509_REVOKED_set_revocationDate(revoked, asn1_time(now).get());
    X509_CRL_add0_revoked(list.get(), revoked);
  }
  X509_CRL_sort(list.get());
  if (X509_CRL_sign(list.get(), key.get(), EVP_sha256()) <= 0)
    return refusal("signing the list of revoked certificates");
  const Memory text(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509_CRL(text.get(), list.get()) != 1)
    return refusal("writing the list of revoked certificates");
  return content(text);
}

Result<std::string> sign(const std::string& document, const KeyPair& authority) {
  TONUS_TRY_ASSIGN(const Certificate issuer, parse_certificate(authority.certificate));
  TONUS_TRY_ASSIGN(const Key key, parse_key(authority.key));
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED | PKCS7_STREAM;
  const Memory text = reading(document);
  const Document made(PKCS7_sign(issuer.get(), key.get(), nullptr, text.get(), kFlags));
  const Memory out(BIO_new(BIO_s_mem()));
  if (!made || SMIME_write_PKCS7(out.get(), made.get(), text.get(), kFlags) != 1)
    return refusal("signing a document");
  return content(out);
}

Result<CertificateState> read_certificate(const std::string& pem) {
  TONUS_TRY_ASSIGN(const Certificate certificate, parse_certificate(pem));
  CertificateState state;
  constexpr int kLongestName = 256;
  std::string name(kLongestName, '\0');
  const int size = X509_NAME_get_text_by_NID(X509_get_subject_name(certificate.get()), NID_commonName,
                                             name.data(), kLongestName);
  name.resize(static_cast<std::size_t>(std::max(size, 0)));
  state.common_name = std::move(name);
  TONUS_TRY_ASSIGN(state.serial, serial_of(X509_get0_serialNumber(certificate.get())));
  state.begin = utc_time(X509_get0_notBefore(certificate.get()));
  state.end = utc_time(X509_get0_notAfter(certificate.get()));
  return state;
}

Result<std::vector<std::uint64_t>> read_revocations(const std::string& pem) {
  TONUS_TRY_ASSIGN(const Revocations list, parse_revocations(pem));
  std::vector<std::uint64_t> serials;
  STACK_OF(X509_REVOKED)* revoked = X509_CRL_get_REVOKED(list.get());
  for (int i = 0; i < sk_X509_REVOKED_num(revoked); ++i) {
    TONUS_TRY_ASSIGN(const std::uint64_t serial,
                     serial_of(X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(revoked, i))));
    serials.push_back(serial);
  }
  return serials;
}

}  // namespace tonus::pki

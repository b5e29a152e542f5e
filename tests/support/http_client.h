// A client that sends just the bytes it is told to, so that tests can be rude.
#pragma once

#include <map>
#include <optional>
#include <string>

namespace caustic::test {

struct HttpReply {
  int status = 0;                              ///< 0: the connection closed without an answer
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;
};

/// One connection to 127.0.0.1.
class HttpConnection {
 public:
  explicit HttpConnection(int port);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// False if the other end does not take it.
  bool send(const std::string& bytes);
  /// The next answer; `head_only` after a HEAD request.
  HttpReply receive(bool head_only = false);
  /// All that comes until the server closes the connection.
  std::string receive_rest();
  /// True if the server has closed the connection.
  bool closed_by_server();

 private:
  bool fill();

  int socket_;
  std::string buffer_;
};

HttpReply http_get(int port, const std::string& target, const std::string& method = "GET");
HttpReply http_post(int port, const std::string& target, const std::string& body,
                    const std::string& type = "application/json");
/// True once the server computes something; false if it does not come to that.
bool is_computing(int port);
/// Head of a POST with these extra header lines (each ended by \r\n).
std::string post_head(const std::string& target, const std::string& headers);

}  // namespace caustic::test

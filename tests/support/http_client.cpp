#include "tests/support/http_client.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>
#include <utility>

namespace caustic::test {

HttpConnection::HttpConnection(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{60, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
}

HttpConnection::~HttpConnection() { close(socket_); }

bool HttpConnection::send(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t sent = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    done += static_cast<std::size_t>(sent);
  }
  return true;
}

bool HttpConnection::fill() {
  char bytes[65536];
  const ssize_t count = recv(socket_, bytes, sizeof bytes, 0);
  if (count <= 0) return false;
  buffer_.append(bytes, static_cast<std::size_t>(count));
  return true;
}

std::string HttpConnection::receive_rest() {
  while (fill()) {
  }
  return std::exchange(buffer_, {});
}

bool HttpConnection::closed_by_server() { return !fill(); }

HttpReply HttpConnection::receive(bool head_only) {
  HttpReply reply;
  std::size_t end;
  while ((end = buffer_.find("\r\n\r\n")) == std::string::npos)
    if (!fill()) return reply;
  std::istringstream head(buffer_.substr(0, end));
  buffer_.erase(0, end + 4);
  std::string line;
  std::getline(head, line);
  if (line.size() > 12) reply.status = std::stoi(line.substr(9, 3));
  while (std::getline(head, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const auto colon = line.find(':');
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    reply.headers[name] = line.substr(std::min(line.size(), colon + 2));
  }
  if (reply.status == 100) return receive(head_only);
  const auto length = reply.headers.find("content-length");
  const std::size_t size = length == reply.headers.end() ? 0 : std::stoull(length->second);
  while (!head_only && buffer_.size() < size)
    if (!fill()) break;
  if (!head_only) {
    reply.body = buffer_.substr(0, size);
    buffer_.erase(0, size);
  }
  return reply;
}

HttpReply http_get(int port, const std::string& target, const std::string& method) {
  HttpConnection connection(port);
  connection.send(method + " " + target + " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  return connection.receive(method == "HEAD");
}

bool is_computing(int port) {
  for (int i = 0; i < 6000; ++i) {
    if (http_get(port, "/metrics").body.find("isocaustic_running 1\n") != std::string::npos)
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

std::string post_head(const std::string& target, const std::string& headers) {
  return "POST " + target + " HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n";
}

HttpReply http_post(int port, const std::string& target, const std::string& body,
                    const std::string& type) {
  HttpConnection connection(port);
  connection.send(post_head(target, "Connection: close\r\nContent-Type: " + type +
                                        "\r\nContent-Length: " + std::to_string(body.size()) +
                                        "\r\n") +
                  body);
  return connection.receive();
}

}  // namespace caustic::test

#include "tests/fuzz/mutations.h"

#include <nlohmann/json.hpp>

namespace caustic::test {
namespace {

using nlohmann::json;

const std::vector<std::string> kPieces = {"\r\n",
                                          "\n",
                                          "\r",
                                          " ",
                                          "\t",
                                          ":",
                                          ",",
                                          "0",
                                          "-1",
                                          "1e308",
                                          "1e-320",
                                          "99999999999999999999",
                                          "{",
                                          "}",
                                          "[",
                                          "]",
                                          "\"",
                                          "\\u0000",
                                          "null",
                                          "true",
                                          "NaN",
                                          "Content-Length: 5\r\n",
                                          "Transfer-Encoding: chunked\r\n",
                                          "HTTP/1.1",
                                          "GET ",
                                          "(",
                                          ")",
                                          "^",
                                          "sqrt(",
                                          "/",
                                          "x",
                                          std::string("\0", 1),
                                          "\xff",
                                          "%00",
                                          "../",
                                          "A: b\r\n"};

json odd_value(Random& random) {
  static const std::vector<json> values = {nullptr,
                                           true,
                                           0,
                                           -1,
                                           1e308,
                                           -1e308,
                                           1e-320,
                                           0.5,
                                           1e17,
                                           "",
                                           "ball",
                                           "x^2+y^2-z",
                                           "\xc3\xa9\n",
                                           json::array(),
                                           json::object(),
                                           {0, 0, 0},
                                           {1e200, 1, 1},
                                           {1, 2},
                                           {"ball", "ball"},
                                           {{"type", "plane"}},
                                           std::string(300, 'a')};
  return values[static_cast<std::size_t>(random.index(static_cast<int>(values.size())))];
}

/// Goes down from `node` to somewhere, and changes that.
void change(json& node, Random& random) {
  json* place = &node;
  while (place->is_structured() && !place->empty() && random.index(5) > 0) {
    auto child = place->begin();
    std::advance(child, random.index(static_cast<int>(place->size())));
    place = &*child;
  }
  const int kind = random.index(6);
  if (place->is_number() && kind < 3) {
    *place = place->get<double>() * random.sign() * std::pow(10.0, random.uniform(-9, 9));
  } else if (place->is_array() && !place->empty() && kind < 3) {
    if (kind == 0) place->erase(0);
    if (kind > 0) place->push_back((*place)[0]);
  } else if (place->is_object() && !place->empty() && kind < 2) {
    place->erase(place->begin().key());
  } else if (place->is_object() && kind == 2) {
    (*place)["unknown"] = 1;
  } else {
    *place = odd_value(random);
  }
}

}  // namespace

std::string Mutations::bytes(std::string text) {
  for (int n = 1 + random_.index(4); n > 0; --n) {
    const auto at = [&] {
      return static_cast<std::size_t>(random_.index(static_cast<int>(text.size()) + 1));
    };
    const std::size_t begin = at(), length = static_cast<std::size_t>(random_.index(20));
    switch (random_.index(5)) {
      case 0:
        if (begin < text.size()) text[begin] = static_cast<char>(random_.index(256));
        break;
      case 1:
        text.erase(begin, length);
        break;
      case 2:
        text.insert(
            begin,
            kPieces[static_cast<std::size_t>(random_.index(static_cast<int>(kPieces.size())))]);
        break;
      case 3:
        text.insert(begin, text.substr(at(), length));
        break;
      default:
        if (random_.index(4) == 0) text.resize(begin);
    }
  }
  return text;
}

std::string Mutations::document(const std::string& text) {
  json document = json::parse(text, nullptr, false);
  if (document.is_discarded()) return bytes(text);
  for (int n = 1 + random_.index(3); n > 0; --n) change(document, random_);
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string Mutations::next(const std::vector<std::string>& seeds) {
  const auto pick = [&] {
    return seeds[static_cast<std::size_t>(random_.index(static_cast<int>(seeds.size())))];
  };
  const std::string seed = pick();
  if (random_.index(3) == 0) return bytes(seed);
  if (seed.starts_with('{')) return document(seed);
  const auto end = seed.find("\r\n\r\n{"), length = seed.find("Content-Length: ");
  if (end == seed.npos || length == seed.npos)
    return bytes(seed + (random_.index(4) ? "" : pick()));
  const std::string body = document(seed.substr(end + 4));
  return seed.substr(0, length) + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" +
         body;
}

}  // namespace caustic::test

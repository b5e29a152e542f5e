#include "service/api/json_text.h"

#include <cassert>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "service/api/problem.h"

namespace caustic::service {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& detail) {
  throw ProblemError(make_problem(400, detail));
}

/// A piece of hostile text, fit for a message.
std::string quoted(std::string&& text) {
  return json(std::move(text)).dump(-1, ' ', true, json::error_handler_t::replace);
}

/// Builds the document while the text is scanned, so that a limit holds before memory is spent.
class StrictBuilder : public nlohmann::json_sax<json> {
 public:
  json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return add(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return add(value + 0.0); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(json::object()); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    const auto [member, is_new] = stack_.back()->get_ref<json::object_t&>().emplace(name, nullptr);
    if (!is_new) refuse("duplicate key " + quoted(name.substr(0, 100)));
    slot_ = &member->second;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token,
                   const json::exception& error) override {
    const std::string near = quoted(token.substr(0, 60));
    if (error.id == 406) refuse("a number beyond the range of double: " + near);
    refuse("not JSON at byte " + std::to_string(position) + ", near " + near);
  }

 private:
  json* place(json&& value) {
    if (++values_ > kMaxJsonValues)
      refuse("more than " + std::to_string(kMaxJsonValues) + " values");
    if (stack_.empty()) return &(root_ = std::move(value));
    if (stack_.back()->is_object()) return &(*slot_ = std::move(value));
    stack_.back()->push_back(std::move(value));
    return &stack_.back()->back();
  }
  bool add(json&& value) { return place(std::move(value)) != nullptr; }
  bool open(json&& container) {
    if (stack_.size() >= kMaxJsonDepth)
      refuse("nested deeper than " + std::to_string(kMaxJsonDepth));
    stack_.push_back(place(std::move(container)));
    return true;
  }
  bool close() {
    stack_.pop_back();
    return true;
  }

  json root_;
  std::vector<json*> stack_;  ///< open containers; a container moves only after its parts are done
  json* slot_ = nullptr;      ///< where the value of the last key goes
  int values_ = 0;
};

template <typename Json>
void write(std::string& out, const Json& value) {
  const char* separator = "";
  switch (value.type()) {
    case Json::value_t::object:
      out += '{';
      for (const auto& [key, member] : value.items()) {
        out.append(separator).append(Json(key).dump()) += ':';
        write(out, member);
        separator = ",";
      }
      out += '}';
      break;
    case Json::value_t::array:
      out += '[';
      for (const Json& element : value) {
        out += separator;
        write(out, element);
        separator = ",";
      }
      out += ']';
      break;
    case Json::value_t::number_float:
      append_number(out, value.template get<double>());
      break;
    default:
      out += value.dump();
  }
}

}  // namespace

json parse_json(std::string_view text) {
  if (text.empty()) refuse("the body is empty");
  // The scanner takes a zero byte for the end and would not see what follows.
  if (const auto zero = text.find('\0'); zero != text.npos)
    refuse("not JSON at byte " + std::to_string(zero + 1) + ", a zero byte");
  StrictBuilder builder;
  json::sax_parse(text.begin(), text.end(), &builder);
  return builder.take();
}

void append_number(std::string& out, double value) {
  assert(std::isfinite(value));
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  out.append(buffer, end);
}

std::string write_json(const json& document) {
  std::string out;
  write(out, document);
  return out;
}

std::string write_json(const nlohmann::ordered_json& document) {
  std::string out;
  write(out, document);
  return out;
}

}  // namespace caustic::service

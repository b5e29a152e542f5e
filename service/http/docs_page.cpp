#include "service/http/docs_page.h"

#include <nlohmann/json.hpp>

namespace caustic::service {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kPageStyle =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;"
    "color:#222;background:#fff}code,pre{font:14px/1.4 ui-monospace,monospace}"
    "pre{background:#f4f4f4;padding:1rem;overflow-x:auto}h2{margin:2rem 0 .3rem;font-size:1.15rem}"
    "table{border-collapse:collapse}td,th{text-align:left;padding:.2rem 1rem .2rem 0;"
    "vertical-align:top}a{color:#0645ad}"
    "@media(prefers-color-scheme:dark){body{color:#ddd;background:#111}pre{background:#222}"
    "a{color:#8ab4f8}}";

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string text_of(const ordered_json& object, const char* key) {
  return html_text(object.value(key, std::string()));
}

/// A link to the schema it refers to, else the schema itself.
std::string schema_html(const ordered_json& schema) {
  if (!schema.contains("$ref")) return "<pre>" + html_text(schema.dump(2)) + "</pre>";
  const std::string target = schema["$ref"], name = target.substr(target.rfind('/') + 1);
  return "<a href=\"#" + html_text(name) + "\">" + html_text(name) + "</a>";
}

/// Media types with their schemas.
std::string content_html(const ordered_json& holder) {
  std::string out;
  if (!holder.contains("content")) return out;
  for (const auto& [type, media] : holder["content"].items())
    out += "<code>" + html_text(type) + "</code> " + schema_html(media["schema"]) + ' ';
  return out;
}

std::string parameters_html(const ordered_json& operation) {
  std::string out;
  if (!operation.contains("parameters")) return out;
  for (const ordered_json& parameter : operation["parameters"])
    out += "<tr><td><code>" + text_of(parameter, "name") + "</code></td><td>" +
           text_of(parameter, "in") + "</td><td>" + text_of(parameter, "description") +
           "</td></tr>";
  return "<table><tr><th>Parameter</th><th>in</th><th></th></tr>" + out + "</table>";
}

std::string operation_html(const std::string& path, std::string method,
                           const ordered_json& operation) {
  for (char& c : method) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string out = "<h2><code>" + method + ' ' + html_text(path) + "</code></h2>\n<p>" +
                    text_of(operation, "summary") + "</p>\n" + parameters_html(operation);
  if (operation.contains("requestBody"))
    out += "<p>Body: " + content_html(operation["requestBody"]) + "</p>\n";
  out += "<table><tr><th>Status</th><th></th><th>Body</th></tr>\n";
  for (const auto& [status, response] : operation["responses"].items())
    out += "<tr><td>" + html_text(status) + "</td><td>" + text_of(response, "description") +
           "</td><td>" + content_html(response) + "</td></tr>\n";
  return out + "</table>\n";
}

}  // namespace

std::string docs_page(std::string_view openapi) {
  const ordered_json document = ordered_json::parse(openapi);
  const ordered_json& info = document["info"];
  const std::string title = text_of(info, "title") + ' ' + text_of(info, "version");
  std::string out = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                    title +
                    "</title><meta name=\"viewport\" content=\"width=device-width\"><style>" +
                    std::string(kPageStyle) + "</style></head><body>\n<h1>" + title + "</h1>\n<p>" +
                    text_of(info, "summary") + ". " + text_of(info, "description") +
                    " The same for programs: <a href=\"/openapi.json\">openapi.json</a>.</p>\n";
  for (const auto& [path, methods] : document["paths"].items())
    for (const auto& [method, operation] : methods.items())
      out += operation_html(path, method, operation);
  for (const auto& [name, schema] : document["components"]["schemas"].items())
    out += "<h2 id=\"" + html_text(name) + "\">" + html_text(name) + "</h2>\n<pre>" +
           html_text(schema.dump(2)) + "</pre>\n";
  return out + "</body></html>\n";
}

}  // namespace caustic::service

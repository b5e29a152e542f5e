// openapi.json as a page to read and to try: Swagger UI, bundled.
import SwaggerUI from "swagger-ui-dist/swagger-ui-es-bundle.js";
import "swagger-ui-dist/swagger-ui.css";
import { ask } from "./api";
import "./docs.css";
import { token } from "./token";

interface SentRequest {
  headers: Record<string, string>;
}

void ask("/openapi.json").then(async (response) =>
  SwaggerUI({
    spec: await response.json(),
    dom_id: "#docs",
    deepLinking: true,
    validatorUrl: null,
    requestInterceptor(request: SentRequest) {
      if (token()) request.headers["Authorization"] ??= `Bearer ${token()}`;
      return request;
    },
  }),
);

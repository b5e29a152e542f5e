// Expressions in x, y, z as the service reads them: + - * / ^, functions, numbers. To look at, not to compute by.
export type Expression = (x: number, y: number, z: number) => number;

const FUNCTIONS: Record<string, (a: number) => number> = {
  sqrt: Math.sqrt, sin: Math.sin, cos: Math.cos, exp: Math.exp, log: Math.log, abs: Math.abs,
};

/** Null where the text is none. */
export function parseExpression(text: string): Expression | null {
  const words = text.match(/\d*\.?\d+(?:[eE][+-]?\d+)?|\d+\.?|[a-z]+|[-+*/^()]/g) ?? [];
  let at = 0;
  const take = (word: string) => words[at] === word && ++at > 0;

  function sum(): Expression {
    let left = product();
    for (;;) {
      const a = left;
      if (take("+")) { const b = product(); left = (x, y, z) => a(x, y, z) + b(x, y, z); }
      else if (take("-")) { const b = product(); left = (x, y, z) => a(x, y, z) - b(x, y, z); }
      else return left;
    }
  }
  function product(): Expression {
    let left = signed();
    for (;;) {
      const a = left;
      if (take("*")) { const b = signed(); left = (x, y, z) => a(x, y, z) * b(x, y, z); }
      else if (take("/")) { const b = signed(); left = (x, y, z) => a(x, y, z) / b(x, y, z); }
      else return left;
    }
  }
  function signed(): Expression {
    if (take("-")) { const a = signed(); return (x, y, z) => -a(x, y, z); }
    return take("+") ? signed() : power();
  }
  function power(): Expression {
    const a = atom();
    if (!take("^")) return a;
    const b = signed();
    return (x, y, z) => a(x, y, z) ** b(x, y, z);
  }
  function atom(): Expression {
    const word = words[at++];
    if (word === "x") return (x) => x;
    if (word === "y") return (_, y) => y;
    if (word === "z") return (_, __, z) => z;
    if (word === "(") return closed(sum());
    const f = FUNCTIONS[word ?? ""];
    if (f && take("(")) { const a = closed(sum()); return (x, y, z) => f(a(x, y, z)); }
    if (word === "pi") return () => Math.PI;
    const value = Number(word);
    if (!Number.isFinite(value)) throw new SyntaxError(word);
    return () => value;
  }
  function closed(inner: Expression): Expression {
    if (!take(")")) throw new SyntaxError(")");
    return inner;
  }

  try {
    const whole = sum();
    return at === words.length ? whole : null;
  } catch {
    return null;
  }
}

// All that the page knows. It is replaced, never changed; who draws looks at what is new.
import type { ContourAnswer, ContourRequest, CurveCollection, Fault, Reading } from "./contract";

/** Curves and the request that they answer. */
export interface Traced {
  request: ContourRequest;
  answer: ContourAnswer;
  curves: CurveCollection;
  /** Traced while something was dragged: coarse, and not stored. */
  coarse: boolean;
}

export interface State {
  request: ContourRequest;
  /** The name of the example that the request still is. */
  example: string | null;
  /** While something is dragged curves have to follow, not to be exact. */
  dragging: boolean;
  traced: Traced | null;
  faults: Fault[];
  /** Why there are no curves, where no field is at fault. */
  trouble: string | null;
  work: { progress: number; cancel: () => void } | null;
  /** The level that stands out in all views. */
  stressed: number | null;
  /** What the meter reads. */
  reading: Reading | null;
  /** Readings along the curve that was picked. */
  fan: Reading[] | null;
}

type Listener = (now: State, before: State) => void;

export class Store {
  private listeners: Listener[] = [];
  constructor(private state: State) {}

  get now(): State {
    return this.state;
  }

  set(changes: Partial<State>): void {
    const before = this.state;
    this.state = { ...before, ...changes };
    for (const listener of this.listeners) listener(this.state, before);
  }

  edit(request: ContourRequest, dragging = false): void {
    this.set({ request, dragging, example: null, fan: null });
  }

  listen(listener: Listener): void {
    this.listeners.push(listener);
  }

  /** Calls `use` now and whenever one of these members is new. */
  watch(members: (keyof State)[], use: (state: State) => void): void {
    this.listen((now, before) => {
      if (members.some((member) => now[member] !== before[member])) use(now);
    });
    use(this.state);
  }
}

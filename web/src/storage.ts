// What the browser keeps for the page, where it keeps anything.
export const kept = keeper(() => localStorage);
export const keptForTab = keeper(() => sessionStorage);

function keeper(storage: () => Storage) {
  return {
    get(key: string): string | null {
      try {
        return storage().getItem(key);
      } catch {
        return null; // forbidden by the user
      }
    },
    set(key: string, value: string): void {
      try {
        storage().setItem(key, value);
      } catch {
        // forbidden, or full: then it is not kept
      }
    },
  };
}

// Parts of a page. All texts come in as text: nothing that a scenario says becomes markup.

export function part<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  settings: { class?: string; text?: string; title?: string } = {},
  ...inside: Node[]
): HTMLElementTagNameMap[Name] {
  const found = document.createElement(name);
  if (settings.class) found.className = settings.class;
  if (settings.text !== undefined) found.textContent = settings.text;
  if (settings.title) found.title = settings.title;
  found.append(...inside);
  return found;
}

// Say something, unless that is what is said already.
export function say(where: HTMLElement, text: string): void {
  if (where.textContent !== text) where.textContent = text;
}

const DARK = matchMedia("(prefers-color-scheme: dark)");
const colours = new Map<string, string>();
DARK.addEventListener("change", () => colours.clear());

// A colour that the style names.
export function colourOf(name: string): string {
  const found = colours.get(name) ?? getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  colours.set(name, found);
  return found;
}

export function button(text: string, title: string, pressed: () => void): HTMLButtonElement {
  const found = part("button", { text, title });
  found.type = "button";
  found.addEventListener("click", pressed);
  return found;
}

export function choice(title: string, options: [string, string][], chosen: (value: string) => void): [HTMLLabelElement, HTMLSelectElement] {
  const select = part("select", { title });
  offer(select, options);
  select.addEventListener("change", () => chosen(select.value));
  return [part("label", {}, document.createTextNode(title), select), select];
}

// Other options to choose from.
export function offer(select: HTMLSelectElement, options: [string, string][], value?: string): void {
  select.replaceChildren(
    ...options.map(([value, text]) => {
      const option = part("option", { text });
      option.value = value;
      return option;
    }),
  );
  if (value !== undefined) select.value = value;
}

export function swatch(code: string): HTMLCanvasElement {
  const found = part("canvas");
  [found.width, found.height] = [8, 8];
  const pen = found.getContext("2d")!;
  pen.fillStyle = code;
  pen.fillRect(0, 0, 8, 8);
  return found;
}

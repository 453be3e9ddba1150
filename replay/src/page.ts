// Parts of a page. All texts come in as text: nothing that a scenario says becomes markup.

const SVG = "http://www.w3.org/2000/svg";

export function part<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  settings: { class?: string; text?: string; title?: string } = {},
  ...inside: (Node | string)[]
): HTMLElementTagNameMap[Name] {
  const found = document.createElement(name);
  if (settings.class) found.className = settings.class;
  if (settings.text !== undefined) found.textContent = settings.text;
  if (settings.title) found.title = settings.title;
  found.append(...inside);
  return found;
}

// An icon of stackdsl/viewing/style/icons.svg.
export function icon(name: string, large = false): SVGSVGElement {
  const found = document.createElementNS(SVG, "svg");
  found.setAttribute("class", large ? "icon large" : "icon");
  found.setAttribute("aria-hidden", "true");
  const use = document.createElementNS(SVG, "use");
  use.setAttribute("href", `#icon-${name}`);
  found.append(use);
  return found;
}

// Say something, unless that is what is said already.
export function say(where: HTMLElement, text: string): void {
  if (where.textContent !== text) where.textContent = text;
}

// A text in which no unit is parted from its number.
export function kept(text: string): string {
  return text.replace(/(\d) (?=(?:s|mm|m|g|kg|N|mN|kN|MN|deg|%)(?![\w/]))/g, "$1\u00a0");
}

// Put parts somewhere, unless they come of the same things as before.
export function renew(where: HTMLElement, key: string, parts: () => (Node | string)[]): void {
  if (where.dataset.of === key) return;
  where.dataset.of = key;
  where.replaceChildren(...parts());
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

// A button with an icon, a word, or both; one without a word is named by its title.
export function button(text: string, title: string, pressed: () => void, image = ""): HTMLButtonElement {
  const found = part("button", { class: "button", title });
  found.type = "button";
  if (image) found.append(icon(image));
  if (text) found.append(part("span", { text }));
  else found.setAttribute("aria-label", title);
  found.addEventListener("click", pressed);
  return found;
}

// A word in a text that goes somewhere.
export function link(text: string, pressed: () => void): HTMLButtonElement {
  const found = part("button", { class: "go", text });
  found.type = "button";
  found.addEventListener("click", pressed);
  return found;
}

// A button that copies a text, where the browser lets it; else the text is selected, to be copied by hand.
export function copier(text: string, shown: HTMLElement): HTMLButtonElement {
  const found = button("Copy", `copy ${text}`, () => {
    const done = (): void => (say(word, "Copied"), void setTimeout(() => say(word, "Copy"), 1500));
    const byHand = (): void => getSelection()?.selectAllChildren(shown);
    if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, byHand);
    else byHand();
  }, "copy");
  const word = found.querySelector("span")!;
  return found;
}

export function choice(title: string, options: [string, string][], chosen: (value: string) => void): HTMLSelectElement {
  const select = part("select", { class: "button", title });
  select.setAttribute("aria-label", title);
  offer(select, options);
  select.addEventListener("change", () => chosen(select.value));
  return select;
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

export function swatch(code: string, hollow = false): HTMLElement {
  const found = part("i", { class: hollow ? "swatch hollow" : "swatch" });
  found.style[hollow ? "borderColor" : "backgroundColor"] = code;
  return found;
}

let pen: CanvasRenderingContext2D | null = null;

// How wide a text of the line of time is [px].
export function widthOf(text: string): number {
  pen ??= document.createElement("canvas").getContext("2d")!;
  pen.font = `12px ${colourOf("--sans")}`;
  return pen.measureText(text).width;
}

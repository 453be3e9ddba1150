// The tool bar: groups with names. Where they do not fit in one row, groups fold into menus, one after the other.
import { icon, part } from "./page";

const FIRST = ["Explain", "Camera", "Show", "Colour by"]; // which folds first

const PHONE = 640; // [px] up to which all groups are menus

export class Tools {
  readonly element = part("nav", { class: "tools" });
  private readonly groups: HTMLElement[] = [];

  constructor(groups: [string, HTMLElement[]][]) {
    this.element.setAttribute("aria-label", "tools");
    for (const [name, inside] of groups) {
      const opener = part("button", { class: "button opener" }, name, icon("open"));
      opener.type = "button";
      opener.setAttribute("aria-expanded", "false");
      const group = part("div", { class: "group" }, part("span", { class: "label", text: name }), opener, part("div", { class: "inside" }, ...inside));
      group.dataset.name = name;
      opener.addEventListener("click", () => this.open(group.classList.contains("opened") ? undefined : group));
      this.groups.push(group);
    }
    this.element.append(...this.groups);
    addEventListener("pointerdown", (event) => !this.element.contains(event.target as Node) && this.open(undefined));
    this.element.addEventListener("keydown", (event) => {
      const opened = this.groups.find((group) => group.classList.contains("opened"));
      if (event.key !== "Escape" || !opened) return;
      event.stopPropagation();
      this.open(undefined);
      opened.querySelector<HTMLElement>(".opener")!.focus();
    });
    let width = 0;
    new ResizeObserver(() => {
      if (width === this.element.clientWidth) return;
      width = this.element.clientWidth;
      this.fit();
    }).observe(this.element);
  }

  // As much of it in one row as there is room for.
  fit(): void {
    const { element, groups } = this;
    element.classList.remove("wordy");
    for (const group of groups) group.classList.toggle("folded", element.clientWidth <= PHONE);
    const fits = (): boolean => element.scrollWidth <= element.clientWidth;
    element.classList.toggle("wordy", !fits()); // words without icons are shorter
    for (const name of FIRST) {
      if (fits()) return;
      groups.find((group) => group.dataset.name === name)?.classList.add("folded");
    }
  }

  private open(wanted: HTMLElement | undefined): void {
    for (const group of this.groups) {
      group.classList.toggle("opened", group === wanted);
      group.querySelector(".opener")!.setAttribute("aria-expanded", String(group === wanted));
    }
  }
}

import { render } from "preact";
import { Playground } from "./playground";

render(<Playground />, document.getElementById("page")!);

if (import.meta.env.PROD && "serviceWorker" in navigator) {
  // Without it (a private window, say) the page works, but not offline.
  navigator.serviceWorker.register("./sw.js").catch(() => {});
}

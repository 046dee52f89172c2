// The colours of style.css, for what is drawn on a canvas.

let probe: HTMLElement | null = null

/**
 * A colour as canvases take it, for the theme that shows: the text of a custom property may be
 * light-dark(…), which only a real property resolves.
 *
 * @param name  of a custom property: '--ink'
 */
export function cssColor(name: string): string {
  if (!probe) {
    probe = document.createElement('span')
    probe.hidden = true
    document.body.append(probe)
  }
  probe.style.color = `var(${name})`
  return getComputedStyle(probe).color
}

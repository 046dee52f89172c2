// Files that are dropped where nothing takes them: a browser would leave the page for them.

export function holdStrayDrops(): void {
  const hold = (event: DragEvent) => {
    if (event.defaultPrevented) return
    event.preventDefault()
    if (event.dataTransfer) event.dataTransfer.dropEffect = 'none'
  }
  addEventListener('dragover', hold)
  addEventListener('drop', hold)
}

/** Whether files are dragged, and not words or a picture of the page itself. */
export function hasFiles(event: DragEvent): boolean {
  return [...(event.dataTransfer?.types ?? [])].includes('Files')
}

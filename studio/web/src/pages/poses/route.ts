// The place in this page is in the address, #/poses/POSE/TAB/PHOTOGRAPH: it stays over a reload,
// and the browser's back button works.
import { useCallback, useEffect, useState } from 'preact/hooks'

import { kTabs, type Tab } from './tabs'

export interface Place {
  pose: string
  tab: Tab
  /** a photograph or camera, or '' */
  item: string
}

function read(): Place {
  const parts = location.hash.replace(/^#\/?/, '').split('/').slice(1)
  const text = (part: string | undefined) => {
    try {
      return decodeURIComponent(part ?? '')
    } catch {
      return '' // a broken address written by hand
    }
  }
  const tab = kTabs.find((one) => one === parts[1]) ?? 'photographs'
  return { pose: text(parts[0]), tab, item: text(parts[2]) }
}

export function addressOf({ pose, tab, item }: Place): string {
  const parts = [pose, tab, ...(item ? [item] : [])].map(encodeURIComponent)
  return `#/poses/${parts.join('/')}`
}

export function usePlace(): [Place, (place: Place) => void] {
  const [place, setPlace] = useState(read)
  useEffect(() => {
    const changed = () => location.hash.startsWith('#/poses') && setPlace(read())
    addEventListener('hashchange', changed)
    return () => removeEventListener('hashchange', changed)
  }, [])
  const go = useCallback((next: Place) => void (location.hash = addressOf(next)), [])
  return [place, go]
}

/** Asked before the address changes, while there is something to lose; true: it may. */
let mayLeave: ((to: string) => boolean) | null = null
let before = location.hash

// Registered as the program loads, thus before the pages' own listeners, which it can hold up.
addEventListener('hashchange', (event) => {
  if (location.hash === before) return event.stopImmediatePropagation()
  if (!mayLeave || mayLeave(location.hash)) {
    before = location.hash
    return
  }
  event.stopImmediatePropagation()
  history.replaceState(null, '', before)
})

/**
 * While a change could not be saved, the person is asked before it is lost with the page. Where the
 * studio is away, it is saved when that is back.
 */
export function useUnsavedGuard(unsaved: boolean): void {
  useEffect(() => {
    if (!unsaved) return
    const unload = (event: BeforeUnloadEvent) => event.preventDefault()
    mayLeave = () =>
      confirm('The last change could not be saved, and is lost with this page. Leave it?')
    addEventListener('beforeunload', unload)
    return () => {
      mayLeave = null
      removeEventListener('beforeunload', unload)
    }
  }, [unsaved])
}

/**
 * While `dirty`, leaving is held up: `wanted` is the address that the person asked for, to be
 * answered with `stay` or `leave`.
 */
export function useLeaveGuard(dirty: boolean) {
  const [wanted, setWanted] = useState('')
  useEffect(() => {
    if (!dirty) return
    const unload = (event: BeforeUnloadEvent) => event.preventDefault()
    mayLeave = (to) => {
      setWanted(to)
      return false
    }
    addEventListener('beforeunload', unload)
    return () => {
      mayLeave = null
      removeEventListener('beforeunload', unload)
    }
  }, [dirty])
  const stay = useCallback(() => setWanted(''), [])
  const leave = useCallback(() => {
    mayLeave = null
    setWanted('')
    location.hash = wanted
  }, [wanted])
  return { wanted, stay, leave }
}

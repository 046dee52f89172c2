// What pages that play have in common: the player goes with its page, and stops while nobody looks.
import { useEffect, useState } from 'preact/hooks'

import type { Player } from './player'

export function usePauseWhileHidden(player: Player): void {
  useEffect(() => {
    const hidden = () => document.hidden && player.pause()
    document.addEventListener('visibilitychange', hidden)
    return () => {
      document.removeEventListener('visibilitychange', hidden)
      player.pause()
    }
  }, [player])
}

/** The frame at the playhead, as it was when the player last stood: for what only then is shown. */
export function useRestingFrame(player: Player): number {
  const [frame, setFrame] = useState(player.frame)
  useEffect(() => {
    const look = () => !player.playing && setFrame(player.frame)
    const ends = [player.watch(look), player.watchState(look)]
    return () => ends.forEach((end) => end())
  }, [player])
  return frame
}

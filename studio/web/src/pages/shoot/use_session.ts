// The session of the Shoot page.
import { api } from '../../api'
import type { ShootStory, StudioEvent } from '../../api'
import { useToldSession } from '../../use_told_session'
import type { ToldBy, ToldSession } from '../../use_told_session'
import { afterEnd, afterEvent, fromStory, kNoSession } from './session'
import type { Session } from './session'

type Told = Extract<StudioEvent, { type: 'shoot' | 'shoot_ended' }>

const kToldBy: ToldBy<Session, ShootStory, Told> = {
  ask: () => api.shoot(),
  isTold: (event): event is Told => event.type === 'shoot' || event.type === 'shoot_ended',
  start: kNoSession,
  fromStory,
  after: (session, told) =>
    told.type === 'shoot'
      ? afterEvent({ ...session, running: true }, told.event)
      : afterEnd(session, told.message),
}

export const useSession = (): ToldSession<Session, ShootStory> => useToldSession(kToldBy)
